"""Tables, the sea, benchmarks, images, the receiver."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from scenes import ROOT

import nereus


def test_a_table_is_arrays():
    rows = nereus.table("moments", wind_mps=[5, 10, 15])
    assert all(column.shape == (3,) for column in rows.values())
    assert all(column.dtype == float for column in rows.values())


def test_a_table_that_is_none():
    with pytest.raises(nereus.InputError, match="^table: the quantity 'nothing' is unknown; allowed: antenna, .*sigma0"):
        nereus.table("nothing")
    with pytest.raises(nereus.InputError, match="^table: the keyword 'windd' is unknown; did you mean 'wind_mps'.; allowed: aspect_deg, "):
        nereus.table("sigma0", windd=3)
    with pytest.raises(nereus.InputError, match="^invalid value 'x' for wind_mps: invalid float literal$"):
        nereus.table("sigma0", wind_mps="x")


def test_the_sea_as_arrays():
    scene = nereus.Scenario(ROOT / "configs/sea.toml").set({"scene.patch_size_m": [64.0, 32.0], "scene.facet_m": 1.0})
    water = nereus.sea(scene, time_s=2.0)
    assert water["height_m"].shape == (32, 64) == (water.y_m.size, water.x_m.size)
    assert np.diff(water.x_m).tolist() == [1.0] * 63
    assert water.units["slope_x"] == "1" and water.figures["time_s"] == 2.0
    assert 4 * water["height_m"].std() == pytest.approx(water.figures["significant_height_m"], rel=1e-2)


def test_a_scene_without_sea(scene):
    with pytest.raises(nereus.NereusError, match="sea"):
        nereus.sea(scene)


def test_bench_measures(scene):
    report = nereus.bench(scene, pulses=20, error_pulses=2)
    assert report["pulses"] == 20 and report["pulses_per_s"] > 0 and report["rel_rms_db"] < -40


def test_ctrl_c_ends_a_command():
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        nereus.bench(nereus.Scenario(ROOT / "configs/mars-1.toml"))
    assert time.monotonic() - begun < 1.5


def test_focus_finds_the_target(tmp_path, scene):
    pytest.importorskip("h5py")
    scene.set({"target.0.rcs_m2": 1e5}).record(tmp_path / "flight.h5", progress=False)
    options = {"centre_m": (1000.0, 0.0), "size_m": 64.0, "pixel_m": 1.0}
    image = nereus.focus(tmp_path / "flight.h5", channel="VV", **options)
    assert image.values.shape == (1, image.y_m.size, image.x_m.size) and image.channels == ["VV"]
    row, column = np.unravel_index(np.abs(image.values[0]).argmax(), image.values[0].shape)
    assert abs(image.x_m[column] - 1000.0) <= 4.0
    assert image.report["nav"] == "reported"
    with pytest.raises(nereus.InputError, match="allowed: a path, or a dataset"):
        nereus.focus(3)
    with pytest.raises(nereus.MissingFileError, match="no such recording"):
        nereus.focus(tmp_path / "fligth.h5")
    for keywords, words in [
        ({"windw": "hann"}, "^focus: the keyword 'windw' is unknown; did you mean 'window'.; allowed: aperture, centre_m, "),
        ({"json": True}, "the keyword 'json' is unknown"),
        ({"window": "hani"}, "^invalid value 'hani' for window; allowed: none, hann, taylor, kaiser$"),
        ({"pulses": 5}, r"^pulses: 5; allowed: \(first, one past the last\)"),
    ]:
        with pytest.raises(nereus.InputError, match=words):
            nereus.focus(tmp_path / "flight.h5", **keywords)


def test_focus_takes_what_a_dataset_selects(tmp_path, scene):
    pytest.importorskip("xarray")
    path = tmp_path / "flight.h5"
    scene.record(path, pulses=(0, 30), progress=False)
    options = {"centre_m": (1000.0, 0.0), "size_m": 32.0}
    with nereus.open(path) as flight:
        part = flight.sel(channel="HH").isel(pulse=slice(10, 20))
        image, same = nereus.focus(part, **options), nereus.focus(path, pulses=(10, 20), channel="HH", **options)
        assert image.channels == ["HH"] and image.report["pulses"] == same.report["pulses"]
        assert np.array_equal(image.values, same.values)
        assert np.array_equal(nereus.focus(flight, **options).values, nereus.focus(path, **options).values)
        for thinned in (flight.isel(pulse=slice(None, None, 2)), flight.isel(pulse=slice(0, 0))):
            with pytest.raises(nereus.InputError, match="all that are recorded from one pulse to another"):
                nereus.focus(thinned, **options)
        for given in ({"pulses": (10, 20)}, {"channel": "HH"}):
            with pytest.raises(nereus.InputError, match="of a dataset in which some are selected; allowed: one of both"):
                nereus.focus(part, **given, **options)
        assert nereus.focus(flight, pulses=(10, 20), **options).report["pulses"] == 10
        changed = flight.assign(iq=flight.iq * 2)
        moved = flight.copy()
        moved["nav/aircraft/reported/position_m"] = moved["nav/aircraft/reported/position_m"] + 1.0
        for other, words in [
            (flight.isel(sample=slice(0, 64)), "iq of .*'sample': 64.*recorded .*'sample': 128"),
            (flight.isel(sample=slice(None, None, -1)), "iq was changed"),
            (changed, "iq was changed"),
            (changed.sel(channel="VV").isel(pulse=slice(3, 9)), "iq was changed"),
            (flight.drop_vars("iq"), "iq is not in the dataset"),
            (moved, "nav/aircraft/reported/position_m was changed"),
            (flight.assign_coords(channel=["A", "VV"]), "the channel 'A' is unknown; allowed: HH, VV"),
        ]:
            with pytest.raises(nereus.InputError, match=words):
                nereus.focus(other, **options)
        turned = flight[["iq"]].load().transpose("sample", ...)
        assert np.array_equal(nereus.focus(turned, **options).values, nereus.focus(path, **options).values)
    pytest.importorskip("zarr")
    scene.record(tmp_path / "flight.zarr", pulses=(0, 3), progress=False)
    with pytest.raises(nereus.InputError, match="remedy: record an HDF5 file"):
        nereus.focus(tmp_path / "flight.zarr", **options)


def test_pictures(tmp_path, scene):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    scene.record(tmp_path / "flight.h5", pulses=(0, 20), progress=False)
    image = nereus.focus(tmp_path / "flight.h5", centre_m=(1000.0, 0.0), size_m=32.0)
    assert image.plot("HH").get_xlabel() == "East, m" == image.plot(-1).get_xlabel()
    for channel in ("HV", 2):
        with pytest.raises(nereus.InputError, match=f"the channel '{channel}' is unknown.*; allowed: HH, VV"):
            image.plot(channel)
    assert image.to_xarray().dims == ("channel", "y_m", "x_m")


def test_receive_what_is_sent(tmp_path, scene):
    with nereus.receive("127.0.0.1:0", idle_s=0.5, duration_s=20.0) as reception:
        sends = scene.set({
            "scene.duration_s": 0.4,
            "stream.pace": "realtime",
            "sink": [{"kind": "vita49", "address": reception.address}],
        })
        (tmp_path / "send.toml").write_text(sends.text)
        sender = threading.Thread(target=nereus._nereus.main, args=(["run", str(tmp_path / "send.toml")],))
        time.sleep(0.1)
        sender.start()
        pulses = list(reception)
        sender.join()
    assert [pulse.index for pulse in pulses][-1] == 39 and len(pulses) >= 30
    sent = list(sends.stream())
    for pulse in pulses:
        np.testing.assert_array_equal(pulse.iq, sent[pulse.index].iq)
        assert pulse.truth == {}
    np.testing.assert_array_equal(
        pulses[0].reported["aircraft"].position_m, sent[pulses[0].index].reported["aircraft"].position_m
    )
    assert reception.report["pulses"] == len(pulses) and reception.info["channels"] == ["HH", "VV"]


def test_a_closed_reception_reports_it():
    reception = nereus.receive("127.0.0.1:0")
    reception.close()
    with pytest.raises(nereus.StreamClosed, match="nereus.receive"):
        next(reception)


def test_an_address_that_is_none():
    with pytest.raises(nereus.InputError, match="cannot listen at"):
        nereus.receive("nowhere")
