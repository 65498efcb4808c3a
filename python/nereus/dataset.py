"""Recordings as xarray datasets: HDF5 (growing ones, too), plain folders, Zarr.

    ds = nereus.open("flight.h5")
    ds.iq                                     # [pulse, channel, sample], read when it is used
    ds["nav/aircraft/reported/position_m"]    # the names of docs/recording.md
    ds.iq.sel(channel="HH", pulse=slice(100, 200))

Datasets keep their paths as names. Dimensions are those of their attribute `axes`: `pulse`, `channel`,
`sample`, `pair`, `target`, `ship`, `clock`, `change`, `enu` (East-North-up), `quaternion` (w-x-y-z) and
`replica_sample`. `units`, `long_name` and `frame` come from their attributes, those of the file are
`ds.attrs`. ADC counts are read as sqrt(W). The columns of a table are datasets of their own
(`truth/changes/text`). What radiates besides the radar stands along `emitter`: `ds["emitter/carrier_hz"]`.
"""
from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import RecordingError, existing, needs

if TYPE_CHECKING:
    import xarray

WORDS = ("description", "unit", "axes", "frame")
INDEX = "pulse/index"
CODES = "in-phase and quadrature"
VECTORS = {"East-North-up": "enu", "w-x-y-z": "quaternion", CODES: "component"}
LABELS = {"enu": ["east", "north", "up"], "quaternion": ["w", "x", "y", "z"]}
#: Datasets that name what stands along a dimension.
NAMES = {"channel/name": "channel", "truth/targets": "target", "truth/ships": "ship", "truth/clocks": "clock"}
#: Dimensions of a table's rows.
TABLES = {"channel": "channel", "truth/pairs": "pair", "truth/changes": "change"}
CHANGES = "truth/changes"
#: Recordings of earlier versions have no attribute `axes`.
AXES = (
    (r"iq", ("pulse", "channel", "sample")),
    (r"truth/(delay_s|doppler_hz)", ("pulse", "pair", "target")),
    (r"truth/ship_(position_m|velocity_mps)", ("pulse", "ship", "enu")),
    (r"truth/ship_heading_deg", ("pulse", "ship")),
    (r"nav/.*_quat", ("pulse", "quaternion")),
    (r"nav/.*(_m|_mps)", ("pulse", "enu")),
    (r"replica", ("replica_sample",)),
    (r"truth/targets", ("target",)),
    (r"truth/ships", ("ship",)),
    (r"truth/clocks", ("clock",)),
)


@dataclass
class Column:
    """A dataset with a row for each pulse: dimensions, type and shape of all rows, attributes, shape of a chunk."""

    dims: tuple
    dtype: np.dtype
    shape: tuple
    attrs: dict
    chunks: tuple | None = None


@dataclass
class Source:
    """A recording of any kind. `read(name, key)` reads rows of a column; `fixed` is what is there once."""

    path: str
    pulses: int
    attrs: dict
    columns: dict
    fixed: dict
    read: object
    closes: object = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Closes its file."""
        if self.closes:
            self.closes()


def damaged(path, what):
    """The exception for a recording that is not whole."""
    return RecordingError(f"{path}: damaged: {what}; `nereus verify` lists what can be read of an HDF5 file or a folder")


def plain(value):
    """An attribute as a Python value."""
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, np.ndarray):
        return [plain(v) for v in value.tolist()]
    return value.item() if isinstance(value, np.generic) else value


def dimensions(name, axes, rank):
    """Names of the dimensions of a dataset of so many axes."""
    known = tuple(VECTORS.get(axis, axis) for axis in axes.split(", ")) if axes else ()
    if name == "replica":
        known = ("replica_sample",)
    if not known:
        known = next((dims for pattern, dims in AXES if re.fullmatch(pattern, name)), ("pulse",))
    if rank == len(known) + 1:
        known += ("component",)
    return known if len(known) == rank else ("pulse", *(f"{name}_{k}" for k in range(1, rank)))


def source(path):
    """Opens a recording of any kind."""
    path = existing(path, "recording")
    if os.path.isdir(path):
        if os.path.exists(os.path.join(path, "zarr.json")):
            return _zarr(path)
        if os.path.exists(os.path.join(path, "meta.json")):
            return _folder(path)
        raise RecordingError(
            f"{path}: not a recording of nereus: a folder without meta.json (plain) or zarr.json (Zarr)"
        )
    return _hdf5(path)


def open(path: str | os.PathLike[str], chunks: Any = None) -> xarray.Dataset:  # noqa: A001
    """A recording as an `xarray.Dataset` that reads samples when they are used.

    `path` is an HDF5 file, finished, growing or left by a killed run; a folder of plain files; or a Zarr store.
    What a growing recording holds now is what is there: open it again for more. `chunks` as in
    `xarray.open_dataset` gives dask arrays, with the chunks of the recording along dimensions that a dict does not
    name (`chunks={}`: all; plain folders have none). Close it by `ds.close()` or `with`.

    Raises `MissingFileError`, and `RecordingError` where the path is no recording or a damaged one; a damaged
    chunk is found when it is read.
    """
    xr = needs("nereus.open", "xarray", "xarray")
    from xarray.core import indexing

    rec = source(path)
    variables, coords = {}, {}

    def lazy(name, dtype=None, shape=None, convert=None):
        column = rec.columns[name]
        array = _Lazy(rec, name, dtype or column.dtype, shape or column.shape, convert)
        return indexing.LazilyIndexedArray(_backend()(array))

    for name, column in rec.columns.items():
        attrs = _words(column.attrs)
        if column.dims[-1] == "component":
            # Codes of a mid-rise converter.
            convert = _Codes(np.float32(column.attrs["adc_step"]))
            data = lazy(name, np.dtype("complex64"), column.shape[:-1], convert)
            variables[name] = xr.Variable(column.dims[:-1], data, {**attrs, "units": "sqrt(W)"})
        else:
            variables[name] = xr.Variable(column.dims, lazy(name), attrs)
    for name, (dims, values, attrs) in rec.fixed.items():
        named = NAMES.get(name)
        (coords if named else variables)[named or name] = xr.Variable(dims, values, _words(attrs))
    try:
        emitters = _emitters(rec.attrs.get("instrument"))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        rec.close()
        raise damaged(rec.path, f"attribute instrument: {type(error).__name__}: {error}") from error
    for name, (dims, values, attrs) in emitters.items():
        (coords if name == "emitter" else variables)[name] = xr.Variable(dims, values, attrs)
    sizes = {dim: n for variable in variables.values() for dim, n in variable.sizes.items()}
    coords.update({dim: (dim, labels) for dim, labels in LABELS.items() if dim in sizes})
    if "pulse" in sizes:
        coords["pulse"] = ("pulse", _numbers(rec), {"long_name": "number of the pulse in the run"})
        stamp = lazy("pulse/time_ns", np.dtype("datetime64[ns]"), convert=_as_time)
        coords["time"] = xr.Variable("pulse", stamp, {"long_name": "emission, UTC, rounded down to 1 ns"})
    ds = xr.Dataset(variables, coords, rec.attrs)
    ds.encoding["source"] = rec.path
    ds.set_close(rec.close)
    return ds if chunks is None else _chunked(ds, chunks, rec)


def _emitters(instrument):
    """Columns of the table of emitters that stands in the attribute `instrument`; what has no column is there."""
    rows = (json.loads(instrument) if instrument else {}).get("emitters", [])
    if not rows:
        return {}
    units = {"hz": "Hz", "s": "s", "w": "W"}
    columns = {"emitter": (("emitter",), _texts(row["antenna"]["name"] for row in rows), {})}
    columns["emitter/platform"] = (("emitter",), _texts(row["antenna"]["platform"] for row in rows), {})
    for key, first in rows[0].items():
        values = [row[key] for row in rows]
        if isinstance(first, (bool, int, float)):
            unit = units.get(key.rpartition("_")[2])
            columns[f"emitter/{key}"] = (("emitter",), np.array(values), {"units": unit} if unit else {})
        elif isinstance(first, str):
            columns[f"emitter/{key}"] = (("emitter",), _texts(values), {})
    receivers = sorted({name for row in rows for name in row["receivers"]})
    taken = np.array([[name in row["receivers"] for name in receivers] for row in rows]).reshape(len(rows), -1)
    columns["emitter/receiver"] = (("emitter_receiver",), _texts(receivers), {})
    columns["emitter/received"] = (("emitter", "emitter_receiver"), taken, {})
    return columns


def _chunked(ds, chunks, rec):
    """A dataset of dask arrays."""
    if isinstance(chunks, Mapping):
        for name, column in [*rec.columns.items(), ("time", rec.columns["pulse/time_ns"])]:
            own = {dim: n for dim, n in zip(column.dims, column.chunks or ()) if dim in ds[name].dims}
            ds[name] = ds[name].chunk({**own, **{dim: n for dim, n in chunks.items() if dim in ds[name].dims}})
    return ds.chunk(chunks)


def _words(attrs):
    """Attributes as xarray and its plots know them."""
    words = {"long_name": attrs.get("description"), "units": attrs.get("unit"), "frame": attrs.get("frame")}
    words = {k: v for k, v in words.items() if v and v != "none"}
    return {**words, **{k: v for k, v in attrs.items() if k not in WORDS}}


def _numbers(rec):
    """Numbers of the pulses. They ascend, so first and last say whether one is missing."""
    if rec.pulses == 0:
        return np.zeros(0, np.uint64)
    first, last = (int(rec.read(INDEX, (slice(k, k + 1),))[0]) for k in (0, rec.pulses - 1))
    if last - first + 1 == rec.pulses:
        import pandas as pd

        return pd.RangeIndex(first, last + 1)
    return rec.read(INDEX, (slice(0, rec.pulses),))


class _Codes:
    """ADC counts as samples, sqrt(W)."""

    def __init__(self, step):
        self.step = step

    def __call__(self, codes):
        iq = (codes.astype(np.float32) + np.float32(0.5)) * self.step
        return np.ascontiguousarray(iq).view(np.complex64)[..., 0]


def _as_time(ns):
    return np.asarray(ns).astype("int64").view("datetime64[ns]")


@dataclass
class _Lazy:
    """A column that is not read yet."""

    rec: Source
    name: str
    dtype: np.dtype
    shape: tuple
    convert: object

    def read(self, key):
        # A growing recording has more rows by now.
        key = tuple(slice(*k.indices(n)) if isinstance(k, slice) else k for k, n in zip(key, self.shape))
        # The pair of a code is read whole.
        whole = (slice(None),) * (len(self.rec.columns[self.name].shape) - len(self.shape))
        values = self.rec.read(self.name, (*key, *whole))
        return self.convert(values) if self.convert else values


def _backend():
    """The class behind lazy variables; made when xarray is needed."""
    global _Backend
    if _Backend is None:
        from xarray.backends import BackendArray
        from xarray.core import indexing

        class Backend(BackendArray):
            def __init__(self, lazy):
                self.lazy, self.shape, self.dtype = lazy, lazy.shape, lazy.dtype

            def __getitem__(self, key):
                basic = indexing.IndexingSupport.BASIC
                return indexing.explicit_indexing_adapter(key, self.shape, basic, self.lazy.read)

            def __reduce__(self):
                return _restore, (self.lazy,)

        _Backend = Backend
    return _Backend


_Backend = None


def _restore(lazy):
    return _backend()(lazy)


def _texts(values):
    return np.array([v.decode() if isinstance(v, bytes) else str(v) for v in values], dtype=object)


def _checked(rec):
    """Refuses a recording whose columns are shorter than its index."""
    for name, column in rec.columns.items():
        if column.shape[0] < rec.pulses:
            raise damaged(rec.path, f"/{name} has {column.shape[0]} rows for {rec.pulses} pulses")
        column.shape = (rec.pulses, *column.shape[1:])
    return rec


# HDF5


def _hdf5(path):
    h5py = needs("reading HDF5", "xarray", "h5py", "xarray")
    from xarray.backends import CachingFileManager

    swmr = False
    if not h5py.is_hdf5(path):
        raise RecordingError(f"{path}: not a recording of nereus: no HDF5 file, no folder")
    try:
        h5py.File(path, "r").close()
    except OSError as error:
        # A run that goes on, or was killed, leaves the mark of its writer. Nothing else is tried twice: of a
        # damaged file that way would take for ever.
        if "already open" not in str(error):
            raise damaged(path, error) from error
        swmr = True
    manager = CachingFileManager(h5py.File, path, mode="r", kwargs={"swmr": swmr})
    try:
        file = manager.acquire()
    except OSError as error:
        raise damaged(path, error) from error
    try:
        attrs = {k: plain(v) for k, v in file.attrs.items()}
        if attrs.get("format") != "nereus":
            raise RecordingError(f"{path}: not a recording of nereus: an HDF5 file of another program")
        if swmr:
            file[INDEX].refresh()
        pulses = len(file[INDEX])
        columns, fixed, found = {}, {}, {}
        file.visititems(lambda name, item: found.update({name: item}) if isinstance(item, h5py.Dataset) else None)
        for name, item in found.items():
            if swmr:
                item.refresh()
            words = {k: plain(v) for k, v in item.attrs.items()}
            if name in TABLES:
                rows = item[:]
                for key in item.dtype.names:
                    values = rows[key] if rows[key].dtype.kind in "ui" else _texts(rows[key])
                    fixed[f"{name}/{key}"] = ((TABLES[name],), values, words)
            elif item.maxshape and item.maxshape[0] is None:
                dtype, shape = item.dtype, item.shape
                if dtype.names:
                    # As in plain folders.
                    dtype, shape = np.dtype("int16"), (*shape, 2)
                    words["axes"] = f"{words.get('axes', 'pulse, channel, sample')}, {CODES}"
                dims = dimensions(name, words.get("axes"), len(shape))
                columns[name] = Column(dims, dtype, shape, words, item.chunks)
            else:
                values = item[:]
                values = _texts(values) if values.dtype.kind in "OS" else values
                fixed[name] = (dimensions(name, words.get("axes"), 1), values, words)
    except RecordingError:
        manager.close()
        raise
    except (OSError, KeyError, RuntimeError, UnicodeDecodeError, AttributeError, TypeError) as error:
        manager.close()
        raise damaged(path, error) from error
    return _checked(Source(path, pulses, attrs, columns, fixed, _Hdf5Rows(path, manager, swmr), manager.close))


@dataclass
class _Hdf5Rows:
    path: str
    manager: object
    swmr: bool

    def __call__(self, name, key):
        # A chunk that is read in the moment in which it is written again fails its checksum: once more then.
        for wait_s in (0.05, 0.2, 1.0, None) if self.swmr else (None,):
            try:
                dataset = self.manager.acquire()[name]
                if self.swmr:
                    dataset.refresh()
                if not dataset.dtype.names:
                    return dataset[key]
                codes = dataset[key[:-1]]
                return np.stack([codes["r"], codes["i"]], axis=-1)[(..., key[-1])]
            except OSError as error:
                if wait_s is None:
                    raise damaged(self.path, f"/{name}, rows {key[0]}: {error}") from error
                time.sleep(wait_s)


# Plain folders


def _folder(path):
    import builtins

    try:
        with builtins.open(os.path.join(path, "meta.json"), encoding="utf-8") as f:
            meta = json.load(f)
        if not isinstance(meta, dict) or meta.get("format") != "nereus":
            raise RecordingError(f"{path}: not a recording of nereus: meta.json is of another program")
        pulses = os.path.getsize(os.path.join(path, INDEX + ".bin")) // 8
        columns, words = {}, meta.get("descriptions", {})
        for name, entry in meta["columns"].items():
            dtype, row = np.dtype(entry["dtype"]), tuple(entry["shape"])
            size = os.path.getsize(os.path.join(path, name + ".bin"))
            shape = (size // (dtype.itemsize * max(1, int(np.prod(row)))), *row)
            attrs = {k: entry[k] for k in WORDS if k in entry}
            if name == "iq" and dtype.kind == "i":
                attrs |= {"adc_step": meta["adc_step"], "adc_bits": meta["adc_bits"]}
            columns[name] = Column(dimensions(name, attrs.get("axes"), len(shape)), dtype, shape, attrs)
        fixed = {"replica": (("replica_sample",), np.fromfile(os.path.join(path, "replica.bin"), meta["replica_dtype"]), words.get("replica", {}))}
        for name, key in (("truth/targets", "targets"), ("truth/ships", "ships"), ("truth/clocks", "clocks")):
            if meta.get(key):
                fixed[name] = (dimensions(name, None, 1), _texts(meta[key]), words.get(name, {}))
        fixed |= _rows("channel", [{k: c[k] for k in ("name", "transmitter", "receiver", "polarisations")} for c in meta["channel"]], words)
        fixed |= _rows("truth/pairs", meta["pairs"], words) if meta.get("pairs") else {}
        fixed |= _changes_of_folder(path, words)
    except (OSError, KeyError, TypeError, ValueError) as error:
        if isinstance(error, RecordingError):
            raise
        raise damaged(path, f"{type(error).__name__}: {error}") from error
    tables = {"columns", "descriptions", "channel", "pairs", "targets", "ships", "clocks", "replica_dtype", "adc_bits", "adc_step"}
    tables |= {"truth"} if meta.get("truth", True) else set()
    attrs = {k: v for k, v in meta.items() if k not in tables and v is not None}
    attrs |= {k: [c[k] for c in meta["channel"]] for k in ("transmit_basis", "receive_basis") if k in meta["channel"][0]}
    return _checked(Source(path, pulses, attrs, columns, fixed, _FolderRows(path, columns)))


def _rows(table, rows, words):
    """Columns of a table."""
    return {
        f"{table}/{key}": ((TABLES[table],), _texts(row[key] for row in rows), words.get(table, {}))
        for key in rows[0]
    }


def _changes_of_folder(path, words):
    import builtins

    file = os.path.join(path, CHANGES + ".jsonl")
    if not os.path.exists(file):
        return {}
    with builtins.open(file, encoding="utf-8") as f:
        rows = [json.loads(line) for line in f if line.endswith("\n")]
    columns = {}
    for key, dtype in (("pulse", np.uint64), ("time_ns", np.int64), ("platform", None), ("text", None), ("source", None)):
        values = [row[key] for row in rows]
        columns[f"{CHANGES}/{key}"] = (("change",), np.array(values, dtype) if dtype else _texts(values), words.get(CHANGES, {}))
    return columns


@dataclass
class _FolderRows:
    path: str
    columns: dict

    def __call__(self, name, key):
        column = self.columns[name]
        if 0 in column.shape:
            return np.zeros(column.shape, column.dtype)[key]
        rows = np.memmap(os.path.join(self.path, name + ".bin"), column.dtype, "r", shape=column.shape)
        return np.array(rows[key])


# Zarr


def _zarr(path):
    zarr = needs("reading Zarr", "dask", "zarr")

    try:
        group = zarr.open_group(path, mode="r", zarr_format=3)
        attrs = dict(group.attrs)
        if attrs.get("format") != "nereus":
            raise RecordingError(f"{path}: not a recording of nereus: a Zarr store of another program")
        pulses, columns, fixed = group[INDEX].shape[0], {}, {}
        for name, array in arrays_of(group):
            gone = missing_chunks(path, name, array)
            if gone:
                raise damaged(path, f"{gone} chunks of /{name} are missing")
            dims, words = array.metadata.dimension_names, dict(array.attrs)
            if dims[0] == "pulse":
                columns[name] = Column(dims, np.dtype(array.dtype), array.shape, words, array.chunks)
            else:
                values = array[:]
                fixed[name] = (dims, values if values.dtype.kind in "uifc" else _texts(values), words)
    except RecordingError:
        raise
    except Exception as error:
        raise damaged(path, f"{type(error).__name__}: {error}") from error
    return _checked(Source(path, pulses, attrs, columns, fixed, _ZarrRows(path)))


def arrays_of(group, above=""):
    """All arrays of a store by their paths."""
    import zarr

    for name, member in sorted(group.members()):
        if isinstance(member, zarr.Group):
            yield from arrays_of(member, f"{above}{name}/")
        else:
            yield above + name, member


def missing_chunks(path, name, array):
    """Chunks of an array of the store that have no file: Zarr would read zeros."""
    count = int(np.prod([-(-n // c) for n, c in zip(array.shape, array.chunks)]))
    return count - sum(entry.startswith("c.") for entry in os.listdir(os.path.join(path, name)))


@dataclass
class _ZarrRows:
    path: str

    def __call__(self, name, key):
        import zarr

        try:
            return np.asarray(zarr.open_array(os.path.join(self.path, name), mode="r")[key])
        except Exception as error:  # what a codec says of damaged bytes is up to the codec
            raise damaged(self.path, f"/{name}, rows {key[0]}: {error}") from error
