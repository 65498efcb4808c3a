"""Shards and sweeps on Dask: the store of one run, whatever becomes of the workers."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import nereus
import numpy as np
import psutil
import pytest
import xarray as xr
from distributed import Client, LocalCluster

from nereus import distributed

CONFIGS = Path(__file__).parents[2] / "configs"
# How long a silent worker is waited for: long enough for one beside others on two cores.
TIMEOUT_S = 20 if os.environ.get("NEREUS_ALL") else 10
# Workers of the cluster that loses two.
MANY = 8 if os.environ.get("NEREUS_ALL") else 4
EVENTS = [
    {"at_s": 0.25, "platform": "aircraft", "change": "step position.up 5 m"},
    {"at_s": 3.9, "platform": "aircraft", "change": "step position.east 2 m"},
]


def scenario(**more):
    """Errors, clocks, a target, a change of reports early and one late."""
    scene = nereus.Scenario(CONFIGS / "errors.toml")
    for event in EVENTS:
        scene = scene.set({"event.+": event})
    return scene.set(more) if more else scene


@contextlib.contextmanager
def cluster(workers):
    """Worker processes of one thread each, and a client."""
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as made, Client(made) as client:
        yield client


@pytest.fixture(scope="module")
def client():
    with cluster(2) as client:
        yield client


def files(folder):
    """Every file of a store."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(Path(folder).rglob("*")) if p.is_file()}


def one_run(tmp_path, **more):
    scenario(**more).record(tmp_path / "one.zarr", progress=False)
    return files(tmp_path / "one.zarr")


def alone(tmp_path, *names):
    assert sorted(os.listdir(tmp_path)) == sorted(names), "nothing else is left"


def test_shards_make_the_store_of_one_run(client, tmp_path, capsys):
    one = one_run(tmp_path)
    report = distributed.record(scenario(), tmp_path / "d.zarr", client, shards=5)
    assert files(tmp_path / "d.zarr") == one
    assert (report.pulses, report.shards, report.remade) == (888, 5, 0)
    shown = capsys.readouterr().err
    assert "d.zarr: 888 pulses in 5 shards on 2 workers: about" in shown and "pulses/s each" in shown and " MB" in shown
    assert "d.zarr: 5 of 5 in" in shown
    ds = nereus.open(tmp_path / "d.zarr")
    assert list(ds["truth/changes/pulse"].values) == [56, 866]
    assert ds.attrs["config"] == scenario().text, "the scenario as it was given, whatever the threads of a worker"
    alone(tmp_path, "one.zarr", "d.zarr")


def busy(client, store, stop):
    """Waits until shards have been written, and names workers that are making one."""
    partial = lambda: next(Path(store).parent.glob(".*.partial"), None)  # noqa: E731
    while not stop.is_set():
        folder = partial()
        if folder and any(folder.glob("iq/c.*")):
            found = [worker for worker, keys in client.processing().items() if keys]
            if len(found) >= 2:
                return found[:2]
        time.sleep(0.01)
    return []


def test_lost_and_silent_workers(tmp_path):
    """Of many workers one is killed half way, one never answers again."""
    length = {"scene.duration_s": 16.0}
    one = one_run(tmp_path, **length)
    stop, hit = threading.Event(), []
    with cluster(MANY) as client:
        pids = client.run(os.getpid)

        def strike():
            for worker, sent in zip(busy(client, tmp_path / "d.zarr", stop), (signal.SIGKILL, signal.SIGSTOP)):
                os.kill(pids[worker], sent)
                hit.append(pids[worker])

        striker = threading.Thread(target=strike)
        striker.start()
        try:
            report = distributed.record(scenario(**length), tmp_path / "d.zarr", client, shards=24, timeout_s=TIMEOUT_S, progress=False)
        finally:
            stop.set()
            striker.join()
            # What is stopped cannot end by itself.
            for pid in hit[1:]:
                os.kill(pid, signal.SIGKILL)
    assert len(hit) == 2, "the run was over before a worker was hit"
    assert report.remade >= 2
    assert files(tmp_path / "d.zarr") == one
    alone(tmp_path, "one.zarr", "d.zarr")


def test_a_cluster_of_its_own_is_closed(tmp_path):
    before = {child.pid for child in psutil.Process().children(recursive=True)}
    distributed.record(scenario(), tmp_path / "d.zarr", progress=False)
    left = [c for c in psutil.Process().children(recursive=True) if c.pid not in before and "resource_tracker" not in " ".join(c.cmdline())]
    assert not left, left
    assert nereus.open(tmp_path / "d.zarr").sizes["pulse"] == 888


def test_what_cannot_be_is_refused(client, tmp_path):
    scene = scenario()
    for shards in (0, -1, 889):
        with pytest.raises(nereus.InputError, match="allowed: 1 to the 888 pulses"):
            distributed.record(scene, tmp_path / "d.zarr", client, shards=shards)
    distributed.record(scene, tmp_path / "d.zarr", client, progress=False)
    with pytest.raises(nereus.OutputExistsError, match="exists already"):
        distributed.record(scene, tmp_path / "d.zarr", client)
    distributed.record(scene, tmp_path / "d.zarr", client, force=True, progress=False)
    with pytest.raises(nereus.ScenarioError, match="radar.prf_hz"):
        distributed.record(scenario(**{"radar.prf_hz": -1.0}), tmp_path / "e.zarr", client)
    alone(tmp_path, "d.zarr")


def test_workers_without_the_package_are_named(tmp_path):
    with cluster(1) as client:
        def version(other):
            import nereus.distributed

            nereus.distributed.VERSION = other

        client.run(version, "0.0.1")
        with pytest.raises(distributed.WorkerError, match=f"has nereus 0.0.1; allowed: {nereus.__version__}"):
            distributed.record(scenario(), tmp_path / "d.zarr", client)

        def forget():
            sys.modules["nereus.distributed"] = None

        client.run(forget)
        with pytest.raises(distributed.WorkerError, match="cannot import nereus: .*; allowed: nereus .* on every worker"):
            distributed.record(scenario(), tmp_path / "d.zarr", client)
    alone(tmp_path)


def test_a_cluster_that_does_not_answer_is_given_up(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(distributed, "LEAST_S", 2.0)
    with cluster(0) as client:
        with pytest.raises(distributed.WorkerError, match="no worker answers: 0 connected, .*wait_s"):
            distributed.record(scenario(), tmp_path / "d.zarr", client, wait_s=1)
        assert "d.zarr: no worker answers: waiting for one, 1 s at most" in capsys.readouterr().err
    with cluster(1) as client:
        (pid,) = client.run(os.getpid).values()
        os.kill(pid, signal.SIGSTOP)
        try:
            with pytest.raises(distributed.WorkerError, match="no worker answers: 1 connected, 1 given up"):
                distributed.record(scenario(), tmp_path / "d.zarr", client, wait_s=3)
        finally:
            os.kill(pid, signal.SIGKILL)
    alone(tmp_path)


def test_a_case_that_ends_its_workers_is_named():
    def crash(scene):
        os.kill(os.getpid(), signal.SIGKILL)

    with cluster(1) as client:
        expected = "case {'scene.seed': 7}: 3 workers ended at it.*remedy: fewer workers with more threads, or more memory"
        with pytest.raises(distributed.WorkerError, match=expected):
            distributed.sweep(scenario(), {"scene.seed": [7]}, crash, client, progress=False)


def test_a_slow_worker_gets_more_time_and_another_job():
    def slow(scene):
        time.sleep(1.5)
        return 1.0

    with cluster(1) as client:
        found = distributed.sweep(scenario(), {"scene.seed": [7]}, slow, client, timeout_s=0.5, wait_s=20, progress=False)
    assert found.item() == 1.0


def test_long_runs_have_shards_for_workers_that_come_later():
    assert distributed._shards(2, 8.0, 0.1) == 8
    assert distributed._shards(2, 8.0, 2.5) == 2
    assert distributed._shards(1, 86_400.0, 1.4) == 1440
    assert distributed._shards(1, 86_400.0, 550.0) == 15, "a start is a tenth of a shard"


def strongest(scene):
    """The strongest sample of a pulse, and the channels' powers."""
    with scene.stream(pulses=(0, 1)) as pulses:
        iq = next(iter(pulses)).iq
        return {"peak": float(np.abs(iq).max()), "power": (np.abs(iq) ** 2).mean(axis=1)}


def by_value(function):
    """As a user's function is sent, whose module the workers do not have."""
    import cloudpickle

    cloudpickle.register_pickle_by_value(sys.modules[function.__module__])
    return function


def test_a_sweep_is_labelled_by_its_keys(client):
    keys = {"scene.seed": range(3), "target.0.rcs_m2": [1.0, 100.0]}
    found = distributed.sweep(scenario(), keys, by_value(strongest), client, progress=False)
    assert isinstance(found, xr.Dataset)
    assert found.peak.dims == ("scene.seed", "target.0.rcs_m2")
    assert found.power.shape == (3, 2, 2)
    case = {"scene.seed": 2, "target.0.rcs_m2": 100.0}
    here = strongest(scenario(**case))
    assert found.peak.sel(case).item() == here["peak"]
    assert np.array_equal(found.power.sel(case).values, here["power"])
    assert (found.peak.sel({"target.0.rcs_m2": 100.0}) > found.peak.sel({"target.0.rcs_m2": 1.0})).all()

    quiet = nereus.Scenario(CONFIGS / "errors.toml")
    single = distributed.sweep(quiet, {"scene.duration_s": [1, 2]}, lambda scene: scene.pulse_count, client, progress=False)
    assert isinstance(single, xr.DataArray)
    assert list(single.values) == [222, 444] and list(single["scene.duration_s"].values) == [1, 2]

    def labelled(scene):
        return xr.DataArray([1.0, 2.0], {"channel": ["HH", "VV"]}, ["channel"])

    named = distributed.sweep(scenario(), {"scene.seed": [5]}, labelled, client, progress=False)
    assert named.dims == ("scene.seed", "channel") and list(named.channel.values) == ["HH", "VV"]


def test_faults_of_a_sweep_are_named(client):
    scene, quiet = scenario(), nereus.Scenario(CONFIGS / "errors.toml")
    for keys in ({}, {"scene.seed": []}):
        with pytest.raises(nereus.InputError, match="nothing to sweep"):
            distributed.sweep(scene, keys, strongest, client)
    for one in (3, "fast"):
        with pytest.raises(nereus.InputError, match=rf"^scene.seed: {one!r}; allowed: a list of values, such as \[{one!r}\]"):
            distributed.sweep(scene, {"scene.seed": one}, strongest, client)
    with pytest.raises(nereus.ScenarioError, match="scene.sed"):
        distributed.sweep(scene, {"scene.sed": [1]}, strongest, client)
    with pytest.raises(nereus.ScenarioError, match="radar.prf_hz"):
        distributed.sweep(scene, {"radar.prf_hz": [222.0, -1.0]}, strongest, client)
    place = r" \((test_distributed.py, )?line \d+, in <lambda>\)"
    with pytest.raises(nereus.SweepError, match="case {'scene.seed': 7}: ZeroDivisionError: division by zero" + place) as caught:
        distributed.sweep(scene, {"scene.seed": [7]}, lambda scene: 1 / 0, client, progress=False)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)

    class Unsendable(Exception):
        def __reduce__(self):
            raise TypeError("not to be sent")

    def fail(scene):
        raise Unsendable("as it is")

    with pytest.raises(nereus.SweepError, match="case {'scene.seed': 7}: Unsendable: as it is "):
        distributed.sweep(scene, {"scene.seed": [7]}, fail, client, progress=False)
    expected = r"case {'scene.duration_s': 2} returned shape \(444,\), case {'scene.duration_s': 1} shape \(222,\); allowed: the same names"
    with pytest.raises(nereus.InputError, match=expected):
        distributed.sweep(quiet, {"scene.duration_s": [1, 2]}, lambda scene: np.zeros(scene.pulse_count), client, progress=False)


@pytest.mark.parametrize("fails", [False, True])
def test_a_script_without_guard_is_refused_and_faults_are_one_report(tmp_path, fails):
    call = "nereus.distributed.sweep(scene, {'scene.seed': [1]}, lambda scene: 1 / 0, progress=False)"
    script = f"import nereus\n\nscene = nereus.Scenario({str(CONFIGS / 'errors.toml')!r})\n"
    script += f"if __name__ == '__main__':\n    {call}\n" if fails else f"if scene:\n    {call}\n"
    (tmp_path / "script.py").write_text(script)
    run = subprocess.run([sys.executable, tmp_path / "script.py"], capture_output=True, text=True, timeout=120)
    *_, last = run.stderr.splitlines()
    if fails:
        # With the name of the file where cloudpickle sends it.
        text = "nereus.errors.SweepError: case {'scene.seed': 1}: ZeroDivisionError: division by zero (line 5, in <lambda>)"
        assert last.replace("script.py, ", "") == text
    else:
        assert last.endswith('script.py, line 5: every worker would run the script again; remedy: put the call under if __name__ == "__main__":')
    assert run.returncode == 1 and "Compute Failed" not in run.stderr and "Nanny" not in run.stderr


@pytest.mark.parametrize(
    "other, what",
    [
        (xr.DataArray([[1.0, 2.0], [3.0, 4.0]], {"channel": ["HH", "VV"]}, ["sample", "channel"]), "dimensions .sample, channel."),
        (xr.DataArray([[1.0, 2.0], [3.0, 4.0]], {"channel": ["VV", "HH"]}, ["channel", "sample"]), "coordinates .channel."),
        (xr.DataArray([[1.0, 2.0], [3.0, 4.0]], dims=["channel", "sample"]), "coordinates .channel."),
        (np.zeros((2, 2)), "dimensions .none."),
    ],
)
def test_results_of_a_sweep_are_labelled_alike(other, what):
    first = xr.DataArray([[1.0, 2.0], [3.0, 4.0]], {"channel": ["HH", "VV"]}, ["channel", "sample"])
    keys, cases = {"scene.seed": [1, 2]}, [{"scene.seed": 1}, {"scene.seed": 2}]
    assert distributed._labelled(keys, cases, [first, first]).dims == ("scene.seed", "channel", "sample")
    for results in ([first, other], [{"a": first}, {"a": other}]):
        with pytest.raises(nereus.InputError, match=f"case {{'scene.seed': 2}} returned .* of other {what}.*allowed: the same for all"):
            distributed._labelled(keys, cases, results)
