"""Scenarios from files, texts and dicts; faults; reports."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
from scenes import ROOT, small

import nereus


def test_a_file_a_text_and_a_dict_are_the_same_scenario(tmp_path, scene):
    path = tmp_path / "scene.toml"
    path.write_text(scene.text)
    first = [next(nereus.Scenario(of).stream()).iq for of in (path, str(path), scene.text, small())]
    for other in first[1:]:
        np.testing.assert_array_equal(first[0], other)


def test_set_returns_another_scenario(scene):
    longer = scene.set({"scene.duration_s": 2.0, "target.0.rcs_m2": np.float32(10), "target.+": {
        "name": "buoy", "position_m": np.array([900.0, 0.0, 1.0]), "rcs_m2": 1}})
    assert (scene.pulse_count, longer.pulse_count) == (100, 200)
    assert next(longer.stream()).target_delay_s.shape == (1, 2)
    assert "# --set scene.duration_s=2.0" in longer.text


def test_all_faults_are_one_exception_with_the_text_of_the_command_line():
    bad = small()
    bad["radar"]["prf_hz"] = -5
    bad["radar"]["colour"] = "red"
    with pytest.raises(nereus.ScenarioError) as caught:
        nereus.Scenario(bad).check()
    assert len(caught.value.faults) == 2
    lines = str(caught.value).splitlines()
    assert lines[1].startswith("<dict>: radar.prf_hz: -5") and lines[-1] == "<dict>: 2 faults"
    with pytest.raises(nereus.ScenarioError, match=r"^set\(\): radar.prf_hz: -5 is out of range"):
        nereus.Scenario(small()).set({"radar.prf_hz": -5}).check()
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.faults) == (str(caught.value), caught.value.faults)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(nereus.MissingFileError, match="none.toml: no such scenario$"):
        nereus.Scenario(tmp_path / "none.toml")
    with pytest.raises(FileNotFoundError, match="none.toml: no such scenario, the working directory is /"):
        nereus.Scenario("none.toml")
    with pytest.raises(nereus.ScenarioError, match="cannot read scenario"):
        nereus.Scenario(tmp_path)


def test_faults_of_the_build_are_a_scenario_error(scene):
    with pytest.raises(nereus.ScenarioError, match="pulses"):
        scene.stream(pulses=(50, 500))


@pytest.mark.parametrize("value", [float("nan"), object(), {"a": [object()]}])
def test_values_that_no_scenario_has(scene, value):
    with pytest.raises(nereus.InputError, match="scene.seed.*allowed"):
        scene.set({"scene.seed": value})


@pytest.mark.parametrize("value", [None, {"a": [None]}])
def test_none_takes_no_key_away(scene, value):
    with pytest.raises(nereus.InputError, match="^scene.seed.*: None takes no key away; remedy: leave it out of the file or dict"):
        scene.set({"scene.seed": value})


@pytest.mark.parametrize("source", [3, None, ["a"]])
def test_sources_that_are_none(source):
    with pytest.raises(nereus.InputError, match="allowed: a path, TOML text, or a dict"):
        nereus.Scenario(source)


def test_check_reports_text_tables_and_figures(scene):
    report = scene.check()
    data = report.to_dict()
    assert "forecast" in str(report) and data["pulses"] == 100
    assert "<th" in report._repr_html_() and "propagation" in report._repr_html_()
    json.dumps(data)


def test_check_is_what_the_command_line_prints():
    here = nereus.Scenario(ROOT / "configs/selftest.toml").check().to_dict()
    path = str(ROOT / "configs/selftest.toml")
    run = subprocess.run([sys.executable, "-m", "nereus", "check", path, "--json"], capture_output=True, check=True)
    there = json.loads(run.stdout)
    for measured in ("forecast", "plan"):
        here.pop(measured), there.pop(measured)
    assert here == there


def test_a_scenario_can_be_pickled_with_its_arrays(scene):
    track = nereus.trajectory(np.arange(3.0), [[0.0, 60.0 * t, 300.0] for t in range(3)])
    flown = scene.set({"scene.start_utc": "1970-01-01T00:00:00Z", "platform.1.track": track})
    again = pickle.loads(pickle.dumps(flown))
    assert again.text == flown.text
    np.testing.assert_array_equal(next(again.stream()).iq, next(flown.stream()).iq)


def test_a_panic_is_an_exception():
    with pytest.raises(nereus.InternalError, match="a fault of the program: on purpose"):
        nereus._nereus._panic()
