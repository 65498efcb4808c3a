"""Recordings: the same as those of the program, progress, Ctrl-C."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from scenes import small

import nereus

h5py = pytest.importorskip("h5py")


def test_a_recording_is_that_of_the_program(tmp_path, scene):
    (tmp_path / "scene.toml").write_text(scene.text)
    seen = []
    report = nereus.Scenario(tmp_path / "scene.toml").record(
        tmp_path / "here.h5", progress=lambda *status: seen.append(status)
    )
    assert report["pulses"] == 100 and report["files"] == [str(tmp_path / "here.h5")]
    assert seen[-1][:2] == (100, 100)
    there = tmp_path / "there.h5"
    words = ["run", str(tmp_path / "scene.toml"), "--pace", "fast", "--out", str(there)]
    subprocess.run([sys.executable, "-m", "nereus", *words], check=True, capture_output=True)
    with h5py.File(report["files"][0]) as one, h5py.File(there) as other:
        names = []
        one.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert "iq" in names
        for name in names:
            np.testing.assert_array_equal(one[name][()], other[name][()], err_msg=name)
        assert dict(one.attrs)["config"] == other.attrs["config"]


def test_what_exists_is_replaced_with_force_alone(tmp_path, scene):
    for name in ("a", "a.h5", "a.zarr"):
        scene.record(tmp_path / name, pulses=(0, 2), progress=False)
        with pytest.raises(nereus.OutputExistsError, match=f"{name}: exists already; allowed: another name, or force=True"):
            scene.record(tmp_path / name, pulses=(0, 2), progress=False)
        scene.record(tmp_path / name, pulses=(0, 3), progress=False, force=True)
        with pytest.raises(nereus.MissingFileError, match="no: no such folder, for the output"):
            scene.record(tmp_path / "no" / name, progress=False)
    assert (tmp_path / "a" / "pulse" / "index.bin").stat().st_size == 24
    for name in ("mine", "mine.h5", "mine.zarr"):
        (tmp_path / name).write_text("of somebody else")
        with pytest.raises(FileExistsError) as caught:
            scene.record(tmp_path / name, pulses=(0, 2), progress=False, force=True)
        assert isinstance(caught.value, nereus.OutputExistsError)
        assert (tmp_path / name).read_text() == "of somebody else"


def test_ctrl_c_leaves_a_readable_recording(tmp_path):
    endless = nereus.Scenario(small()).set({"scene.duration_s": 100_000.0})
    path = tmp_path / "flight.h5"

    def interrupt(passed, *_):
        if passed > 20:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        endless.record(path, progress=interrupt)
    with h5py.File(path) as file:
        index = file["pulse/index"][()]
        assert 0 < len(index) < 10_000_000 and len(file["iq"]) == len(index)
    verified = subprocess.run([sys.executable, "-m", "nereus", "verify", str(path)], capture_output=True)
    assert verified.returncode == 0, verified.stderr


def test_an_exception_of_the_progress_ends_the_recording(tmp_path, scene):
    def refuse(passed, *_):
        if passed > 20:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        scene.set({"scene.duration_s": 1000.0}).record(tmp_path / "a.h5", progress=refuse)
    with h5py.File(tmp_path / "a.h5") as file:
        assert len(file["pulse/index"]) > 0


def test_a_format_that_is_none(tmp_path, scene):
    with pytest.raises(nereus.InputError, match='allowed: "hdf5", "plain", "zarr"'):
        scene.record(tmp_path / "a", format="wav")
