"""Recordings as datasets: HDF5, growing and killed ones, plain folders, Zarr; what is none of them, or damaged."""

import os
import pickle
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import nereus
import numpy as np
import pytest
import xarray as xr
import zarr

from scenes import small
from nereus import zarr as store
from nereus.dataset import source

CONFIGS = Path(__file__).parents[2] / "configs"
EVENT = {"at_s": 0.25, "platform": "aircraft", "change": "step position.up 5 m"}
ADC = {"bits": 12, "full_scale_dbw": -85.0}


def scenario(**more):
    """Errors, clocks, a target, a change of reports."""
    return nereus.Scenario(CONFIGS / "errors.toml").set({"event.+": EVENT, "scene.duration_s": 2.0, **more})


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The same run in all three kinds."""
    folder = tmp_path_factory.mktemp("recorded")
    scenario().record(folder / "r.h5", progress=False)
    scenario().record(folder / "r.plain", progress=False)
    scenario().record(folder / "r.zarr", progress=False)
    return folder


def same(a, b):
    assert set(a.variables) == set(b.variables)
    assert dict(a.sizes) == dict(b.sizes)
    for name in a.variables:
        assert a[name].dims == b[name].dims, name
        assert a[name].attrs == b[name].attrs, name
        assert np.array_equal(a[name].values, b[name].values), name


def test_dimensions_and_units_are_named(recorded):
    with nereus.open(recorded / "r.h5") as ds, h5py.File(recorded / "r.h5") as file:
        assert ds.iq.dims == ("pulse", "channel", "sample")
        assert ds.iq.attrs["units"] == "sqrt(W)"
        position = ds["nav/aircraft/reported/position_m"]
        assert (position.dims, position.attrs["units"], position.attrs["frame"]) == (("pulse", "enu"), "m", "ENU")
        assert list(position.enu.values) == ["east", "north", "up"]
        assert ds["truth/delay_s"].dims == ("pulse", "pair", "target")
        assert list(ds.target.values) == ["buoy", "boat"]
        assert list(ds["truth/changes/text"].values) == ["step position.up 5 m"]
        assert list(ds["channel/receiver"].values) == ["rx"] * ds.sizes["channel"]
        assert ds.time.values[0] == np.datetime64(int(file["pulse/time_ns"][0]), "ns")
        assert ds.attrs["prf_hz"] == file.attrs["prf_hz"]
        # Every dataset of the file is there.
        found = []
        file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
        labels = {"truth/targets": "target", "truth/clocks": "clock", "channel": "channel/transmitter"}
        tables = {"truth/pairs": "truth/pairs/receiver", "truth/changes": "truth/changes/text"}
        for name in found:
            assert {**labels, **tables}.get(name, name) in ds.variables, name
        assert np.array_equal(ds.iq.sel(channel="HH", pulse=slice(100, 200)).values, file["iq"][100:201, 0])


def test_emitters_stand_along_a_dimension(tmp_path, recorded):
    scene = small()
    common = {"platform": "mast", "antenna": {"kind": "isotropic"}, "waveform": {"kind": "lfm", "bandwidth_hz": 1e6, "pulse_s": 1e-6}}
    scene["emitter"] = [
        {"name": "beacon", "power_w": 2.0, "prf_hz": 250.0, "start_us": -125.0, "polarisation": "V", **common},
        {"name": "jammer", "power_w": 1e-3, "pri_us": [1000.0, 3000.0], "carrier_hz": 10.005e9, "echo": False, **common},
    ]
    for name in ("r.h5", "r.plain", "r.zarr"):
        nereus.Scenario(scene).record(tmp_path / name, progress=False)
        with nereus.open(tmp_path / name) as ds:
            assert list(ds.emitter.values) == ["beacon", "jammer"]
            assert list(ds["emitter/carrier_hz"].values) == [10e9, 10.005e9]
            assert list(ds["emitter/prf_hz"].values) == [250.0, 500.0]
            assert float(ds["emitter/start_s"].sel(emitter="beacon")) == pytest.approx(-125e-6, rel=1e-12)
            assert ds["emitter/power_w"].attrs["units"] == "W" and list(ds["emitter/echo"].values) == [True, False]
            assert list(ds["emitter/polarisation"].values) == ["V", "H"] and list(ds["emitter/platform"].values) == ["mast"] * 2
            assert bool(ds["emitter/received"].sel(emitter="jammer").all()) and list(ds["emitter/receiver"].values) == ["rx"]
    with nereus.open(recorded / "r.h5") as ds:
        assert "emitter" not in ds.dims
    with nereus.Scenario(scene).stream() as stream:
        assert [row["antenna"]["name"] for row in stream.info["instrument"]["emitters"]] == ["beacon", "jammer"]


def test_samples_are_read_when_they_are_used(recorded, monkeypatch):
    ds = nereus.open(recorded / "r.h5")
    read = []
    whole = type(source(recorded / "r.h5").read).__call__
    monkeypatch.setattr(type(source(recorded / "r.h5").read), "__call__", lambda s, n, k: read.append((n, k)) or whole(s, n, k))
    part = ds.iq[10:20, :, ::-2]
    assert not read
    assert part.values.shape == (10, ds.sizes["channel"], ds.sizes["sample"] // 2)
    assert [(name, key[0]) for name, key in read] == [("iq", slice(10, 20, 1))]
    assert np.array_equal(pickle.loads(pickle.dumps(ds)).iq[5].values, ds.iq[5].values)
    ds.close()


def test_all_kinds_are_the_same_dataset(recorded):
    whole = nereus.open(recorded / "r.h5")
    for kind in ("r.plain", "r.zarr"):
        other = nereus.open(recorded / kind)
        same(whole, other)
        derived = {"start_time_s", "start_time_fraction_s"}  # meta.json has start_time_ns alone
        assert {k: v for k, v in whole.attrs.items() if k not in derived} == {k: v for k, v in other.attrs.items() if k not in derived}
    lazily = nereus.open(recorded / "r.zarr", chunks={"pulse": 100})
    assert lazily.iq.chunks[0][0] == 100
    assert np.array_equal(lazily.iq.values, whole.iq.values)


def test_counts_of_a_converter_are_samples(tmp_path):
    scene = scenario(**{"radar.adc": ADC, "scene.duration_s": 0.5})
    for name in ("a.h5", "a.plain", "a.zarr"):
        scene.record(tmp_path / name, progress=False)
    with h5py.File(tmp_path / "a.h5") as file:
        codes = file["iq"][:]
        step = file["iq"].attrs["adc_step"]
    expected = ((codes["r"] + 0.5 + 1j * (codes["i"] + 0.5)) * step).astype(np.complex64)
    whole = nereus.open(tmp_path / "a.h5")
    np.testing.assert_allclose(whole.iq.values, expected, rtol=1e-6)
    assert whole.iq.attrs["units"] == "sqrt(W)" and whole.iq.attrs["adc_bits"] == 12
    same(whole, nereus.open(tmp_path / "a.plain"))
    same(whole, nereus.open(tmp_path / "a.zarr"))
    kept = zarr.open_array(tmp_path / "a.zarr" / "iq", mode="r")
    assert np.array_equal(kept[:], np.stack([codes["r"], codes["i"]], -1)), "a store keeps the counts"


def test_a_store_is_zarr_for_everybody(recorded):
    tree = xr.open_datatree(recorded / "r.zarr", engine="zarr", consolidated=False)
    assert np.array_equal(tree["iq"].values, nereus.open(recorded / "r.h5").iq.values)
    position = tree["nav/aircraft/reported/position_m"]
    assert position.dims == ("pulse", "enu") and position.attrs["unit"] == "m"
    meta = zarr.open_group(recorded / "r.zarr", mode="r")
    assert meta.attrs["format"] == "nereus" and meta["iq"].metadata.zarr_format == 3
    chunks = {meta[name].chunks[0] for name in ("iq", "pulse/index", "truth/delay_s")}
    assert chunks == {store.chunk_length(444, 0)}


def command(*words):
    return subprocess.Popen([sys.executable, "-m", "nereus", *map(str, words)], stderr=subprocess.DEVNULL)


def test_growing_and_killed_recordings_are_read(tmp_path):
    path = tmp_path / "live.h5"
    run = command("run", CONFIGS / "errors.toml", "--pace", "realtime", "--duration-s", 60, "--set", "stream.policy=slip", "--out", path)
    try:
        counts, deadline = [], time.monotonic() + 60
        while len(set(counts)) < 3 and time.monotonic() < deadline:
            time.sleep(0.1)
            if not path.exists():
                continue
            with nereus.open(path) as ds:
                counts.append(ds.sizes["pulse"])
                assert np.isfinite(ds.iq[-3:].values).all()
                assert len(ds["pulse/time_ns"].values) == counts[-1]
        assert len(set(counts)) >= 3 and counts == sorted(counts), counts
        assert run.poll() is None
    finally:
        run.send_signal(signal.SIGKILL)
        run.wait()
    with nereus.open(path) as ds:
        assert ds.sizes["pulse"] >= counts[-1]
        assert ds.iq.values.shape[0] == ds.sizes["pulse"]


def test_missing_pulses_leave_their_numbers_out(recorded, tmp_path):
    shutil.copytree(recorded / "r.plain", tmp_path / "gap")
    index = np.fromfile(tmp_path / "gap/pulse/index.bin", "<u8")
    index[200:] += 7
    index.tofile(tmp_path / "gap/pulse/index.bin")
    ds = nereus.open(tmp_path / "gap")
    assert list(ds.pulse.values[198:202]) == [198, 199, 207, 208]


def test_what_is_no_recording_is_refused(tmp_path):
    with pytest.raises(nereus.MissingFileError, match="missing.h5: no such recording"):
        nereus.open(tmp_path / "missing.h5")
    (tmp_path / "text.h5").write_text("hello")
    (tmp_path / "folder").mkdir()
    (tmp_path / "other").mkdir()
    (tmp_path / "other/meta.json").write_text('{"format": "another"}')
    h5py.File(tmp_path / "other.h5", "w").close()
    zarr.create_group(tmp_path / "other.zarr")
    for name, why in [
        ("text.h5", "no HDF5 file"), ("folder", "without meta.json"), ("other", "of another program"),
        ("other.h5", "of another program"), ("other.zarr", "of another program"),
    ]:
        with pytest.raises(nereus.RecordingError, match=f"{name}: not a recording of nereus.*{why}"):
            nereus.open(tmp_path / name)


def flip(path, at):
    data = bytearray(path.read_bytes())
    data[at] ^= 0xFF
    path.write_bytes(data)


def test_damage_is_named(recorded, tmp_path):
    shutil.copy(recorded / "r.h5", tmp_path / "d.h5")
    with h5py.File(tmp_path / "d.h5") as file:
        place = file["iq"].id.get_chunk_info(1).byte_offset
    flip(tmp_path / "d.h5", place + 100)
    with nereus.open(tmp_path / "d.h5") as ds:
        ds.iq[:10].load()
        with pytest.raises(nereus.RecordingError, match="d.h5: damaged: /iq, rows slice"):
            ds.iq.load()
    (tmp_path / "cut.h5").write_bytes((recorded / "r.h5").read_bytes()[:5000])
    with pytest.raises(nereus.RecordingError, match="cut.h5: damaged"):
        nereus.open(tmp_path / "cut.h5")

    for damage in ("flip", "lose"):
        shutil.copytree(recorded / "r.zarr", tmp_path / damage)
        chunk = tmp_path / damage / "iq" / "c.1.0.0"
        flip(chunk, chunk.stat().st_size // 2) if damage == "flip" else chunk.unlink()
    with pytest.raises(nereus.RecordingError, match="flip: damaged: /iq"):
        nereus.open(tmp_path / "flip").iq.load()
    with pytest.raises(nereus.RecordingError, match="lose: damaged: 1 chunks of /iq are missing"):
        nereus.open(tmp_path / "lose")

    shutil.copytree(recorded / "r.plain", tmp_path / "short")
    os.truncate(tmp_path / "short/iq.bin", 1000)
    with pytest.raises(nereus.RecordingError, match="short: damaged: /iq has 0 rows for 444 pulses"):
        nereus.open(tmp_path / "short")
    (tmp_path / "short/meta.json").write_text('{"format"')
    with pytest.raises(nereus.RecordingError, match="short: damaged"):
        nereus.open(tmp_path / "short")


def test_a_store_replaces_nothing_unasked(recorded, tmp_path, monkeypatch):
    out = tmp_path / "s.zarr"
    store.convert(recorded / "r.h5", out)
    with pytest.raises(nereus.OutputExistsError, match="exists already"):
        store.convert(recorded / "r.h5", out)
    store.convert(recorded / "r.h5", out, force=True)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes").write_text("of somebody else")
    with pytest.raises(nereus.OutputExistsError, match="only those are replaced"):
        store.convert(recorded / "r.h5", tmp_path / "mine", force=True)
    with pytest.raises(nereus.MissingFileError, match="no: no such folder"):
        store.convert(recorded / "r.h5", tmp_path / "no/s.zarr")

    def full(*_):
        raise OSError("no space left")

    monkeypatch.setattr(store, "write_rows", full)
    for out, force in ((tmp_path / "new.zarr", False), (out, True)):
        with pytest.raises(OSError, match="no space left"):
            store.convert(recorded / "r.h5", out, force=force)
    assert sorted(os.listdir(tmp_path)) == ["mine", "s.zarr"]
    same(nereus.open(recorded / "r.h5"), nereus.open(tmp_path / "s.zarr"))


class Ends:
    """A run that leaves a part and raises."""

    def __init__(self, part, error):
        self.part, self.error = part, error

    def record(self, path, **_):
        if self.part:
            shutil.copy(self.part, path)
        raise self.error


@pytest.fixture(scope="module")
def without_pulses(recorded, tmp_path_factory):
    path = shutil.copy(recorded / "r.h5", tmp_path_factory.mktemp("empty") / "empty.h5")
    with h5py.File(path, "r+") as file:
        columns = []
        file.visititems(lambda _, item: columns.append(item) if isinstance(item, h5py.Dataset) and item.maxshape[0] is None else None)
        for column in columns:
            column.resize(0, axis=0)
    return path


@pytest.mark.parametrize("error", [KeyboardInterrupt(), nereus.RunError("disk full"), ZeroDivisionError("of progress")])
def test_a_run_that_ends_early_leaves_its_pulses_or_what_was_there(recorded, without_pulses, tmp_path, error):
    out = tmp_path / "s.zarr"
    shutil.copytree(recorded / "r.zarr", out)
    before = tree(out)
    for part in (None, without_pulses):
        with pytest.raises(type(error)):
            store.record(Ends(part, error), out, force=True)
        assert tree(out) == before and os.listdir(tmp_path) == ["s.zarr"]
    new = tmp_path / "new.zarr"
    with pytest.raises(type(error)):
        store.record(Ends(recorded / "r.h5", error), new)
    same(nereus.open(recorded / "r.h5"), nereus.open(new))
    assert sorted(os.listdir(tmp_path)) == ["new.zarr", "s.zarr"]


@pytest.mark.parametrize("error, raised", [(OSError("no space left"), nereus.RunError), (KeyboardInterrupt(), KeyboardInterrupt)])
def test_a_part_that_cannot_be_converted_stays(recorded, tmp_path, monkeypatch, error, raised):
    def full(*_):
        raise error

    monkeypatch.setattr(store, "write_rows", full)
    with pytest.raises(raised, match="s.zarr: not made: .*the pulses are in .*/s.*h5") as met:
        store.record(Ends(recorded / "r.h5", nereus.RunError("ended")), tmp_path / "s.zarr")
    (kept,) = os.listdir(tmp_path)
    assert str(tmp_path / kept) in str(met.value)
    monkeypatch.undo()
    store.convert(tmp_path / kept, tmp_path / "s.zarr")
    same(nereus.open(recorded / "r.h5"), nereus.open(tmp_path / "s.zarr"))


def test_a_store_that_cannot_be_replaced_stays(recorded, tmp_path, monkeypatch):
    out, rename = tmp_path / "s.zarr", Path.rename
    store.convert(recorded / "r.h5", out)
    before = tree(out)

    def busy(path, target):
        if path.suffix == ".partial" and Path(target) == out:
            raise OSError("busy")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", busy)
    with pytest.raises(nereus.OutputExistsError, match="the complete store is .*partial, the older one .*/s.zarr: busy") as met:
        store.convert(recorded / "r.h5", out, force=True)
    monkeypatch.undo()
    assert tree(out) == before
    complete = str(met.value).split("complete store is ")[1].split(",")[0]
    assert tree(complete) == before
    assert sorted(os.listdir(tmp_path)) == sorted([Path(complete).name, "s.zarr"])

    (out / "iq" / "c.1.0.0").unlink()
    with pytest.raises(nereus.OutputExistsError, match="damaged: .*; rename or remove it, or give another name"):
        store.convert(recorded / "r.h5", out, force=True)


def test_what_late_writers_hold_up_is_not_in_the_store(recorded, tmp_path, monkeypatch):
    rmtree = shutil.rmtree
    monkeypatch.setattr(shutil, "rmtree", lambda path, **more: None if "writing" in Path(path).name else rmtree(path, **more))
    store.convert(recorded / "r.h5", tmp_path / "s.zarr")
    assert not (tmp_path / "s.zarr" / store.WRITING).exists()


def test_blocks_are_the_chunks_of_the_recording(recorded):
    with h5py.File(recorded / "r.h5") as file:
        chunks = {name: file[name].chunks[0] for name in ("iq", "pulse/index")}
    ds = nereus.open(recorded / "r.h5", chunks={})
    assert {name: ds[name].chunks[0][0] for name in chunks} == {name: min(n, 444) for name, n in chunks.items()}
    assert len(ds.iq.chunks[0]) > 1
    with_store = nereus.open(recorded / "r.zarr", chunks={"channel": 1})
    assert with_store.iq.chunks[:2] == ((64,) * 6 + (60,), (1,) * ds.sizes["channel"])
    assert with_store.time.chunks[0] == with_store["truth/delay_s"].chunks[0] == (64,) * 6 + (60,)
    whole = nereus.open(recorded / "r.h5")
    for lazily in (ds, with_store):
        same(whole, lazily)


def test_rows_written_twice_are_the_same(recorded, tmp_path):
    once = tmp_path / "once.zarr"
    store.convert(recorded / "r.h5", once, chunk_pulses=64)
    draft = store.Draft(tmp_path / "twice.zarr", False)
    with source(recorded / "r.h5") as rec, draft:
        draft.create(store.Outline.of(rec), rec.pulses, 64)
        store.write_rows(draft.path, rec, 0)
        store.write_rows(draft.path, rec, 0)
        with pytest.raises(ValueError, match="no multiple"):
            store.write_rows(draft.path, rec, 1)
        draft.finish()
    assert tree(once) == tree(tmp_path / "twice.zarr")
    # A worker that comes too late makes nothing again.
    with source(recorded / "r.h5") as rec, pytest.raises(FileNotFoundError):
        store.write_rows(draft.path, rec, 0)
    assert sorted(os.listdir(tmp_path)) == ["once.zarr", "twice.zarr"]


def tree(folder):
    """Every file of a store."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(Path(folder).rglob("*")) if p.is_file()}
