"""Recordings as Zarr v3 stores, chunked by pulse.

A store holds every dataset of the recording under the same path, with its attributes; the columns of tables are
arrays of their own (`truth/changes/text`), ADC counts have a last axis `component` (in-phase, quadrature), as in
a plain folder. Every chunk is a file and has a checksum.

A store is made from a recorded HDF5 part rather than from the stream: columns, words and checksums come from the
one writer that the engine has, memory stays bounded, and a run that ends early still leaves a recording. It grows
under a hidden name beside its own, and gets its name when it is complete.
"""
from __future__ import annotations

import os
import shutil
import tempfile
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .dataset import CHANGES, Source, arrays_of, missing_chunks, source
from .errors import InputError, InternalError, OutputExistsError, RunError, existing, needs

#: Chunks of a run, at least, where they can have `LEAST` pulses.
CHUNKS = 32
LEAST = 64
#: Bytes of a chunk of samples that are aimed at, and not exceeded by far, however long the run is.
CHUNK_BYTES = 8 << 20
MOST_BYTES = 64 << 20
#: Chunks of a dataset, at most, where MOST_BYTES allow it.
MOST_CHUNKS = 4096
#: What is being written, within the store.
WRITING = ".writing"


def chunk_length(pulses: int, row_bytes: int) -> int:
    """Pulses of a chunk: a power of two that depends on the run alone, so that every way of making it has the same.

    >>> chunk_length(2220, 7168), chunk_length(800_000, 7168), chunk_length(19_180_800, 7168)
    (64, 1024, 8192)
    """

    def below(n):
        return 1 << max(0, int(n).bit_length() - 1)

    row_bytes = max(1, row_bytes)
    wanted = min(below(pulses // CHUNKS), below(CHUNK_BYTES // row_bytes))
    if pulses > wanted * MOST_CHUNKS:
        wanted = min(2 * below(pulses // MOST_CHUNKS), below(MOST_BYTES // row_bytes))
    return max(LEAST, wanted)


@dataclass
class Outline:
    """A recording without its pulses: attributes, columns, and what is there once."""

    attrs: dict
    columns: dict
    fixed: dict

    @classmethod
    def of(cls, rec: Source):
        columns = {n: (c.dims, c.dtype, c.shape[1:], c.attrs) for n, c in rec.columns.items()}
        return cls(rec.attrs, columns, rec.fixed)

    def row_bytes(self):
        """Bytes of a pulse's samples."""
        _, dtype, shape, _ = self.columns["iq"]
        return dtype.itemsize * int(np.prod(shape))

    def pulse_bytes(self):
        """Bytes of all that a pulse has."""
        return sum(d.itemsize * int(np.prod(s)) for _, d, s, _ in self.columns.values())

    def difference(self, other):
        """The first thing in which a part is of another recording; None of the same."""
        own = {"config", "first_pulse", "pulses"}  # the threads of a worker stand in its scenario
        for key in sorted((self.attrs.keys() | other.attrs.keys()) - own):
            if self.attrs.get(key) != other.attrs.get(key):
                return f"{key} ({self.attrs.get(key)!r} and {other.attrs.get(key)!r})"
        if list(self.columns) != list(other.columns):
            return "the list of datasets"
        for name, column in self.columns.items():
            if column != other.columns[name]:
                return f"/{name}"
        for name, (_, values, _) in self.fixed.items():
            if not name.startswith(CHANGES) and not np.array_equal(values, other.fixed[name][1]):
                return f"/{name}"
        return None


class Draft:
    """A store that is being made beside its place."""

    def __init__(self, out, force):
        needs("a Zarr store", "dask", "zarr", "h5py", "xarray")
        self.out = Path(os.path.abspath(out))
        self.force = force
        self.complete = False
        self.refuse()
        existing(self.out.parent, "folder, for the output")
        self.path = self.out.with_name(f".{self.out.name}.{uuid.uuid4().hex[:8]}.partial")

    def refuse(self):
        """Refuses a place that is taken."""
        if not self.out.exists():
            return
        if not self.force:
            raise OutputExistsError(f"{self.out}: exists already; allowed: another name, or force=True, which replaces a Zarr store")
        try:
            if os.path.exists(self.out / "zarr.json") and source(self.out).attrs:
                return
        except InputError as error:
            raise OutputExistsError(f"{self.out}: not replaced: {error}; rename or remove it, or give another name") from error
        raise OutputExistsError(f"{self.out}: exists and is no Zarr store of nereus; only those are replaced")

    def create(self, outline, rows, chunk):
        """Makes all arrays: those of pulses empty, the others filled."""
        import zarr

        self.path.mkdir()
        (self.path / WRITING).mkdir()
        group = zarr.create_group(str(self.path), overwrite=False, zarr_format=3, attributes=outline.attrs)
        for name, (dims, dtype, row, attrs) in outline.columns.items():
            _create(group, name, (rows, *row), dtype, (chunk, *row), dims, attrs)
        for name, (dims, values, attrs) in outline.fixed.items():
            self.fixed(name, dims, values, attrs, group)

    def fixed(self, name, dims, values, attrs, group=None):
        """Writes a dataset that is there once, in place of what it was."""
        import zarr

        group = group if group is not None else zarr.open_group(str(self.path), mode="r+")
        shutil.rmtree(self.path / name, ignore_errors=True)
        dtype = str if values.dtype.kind == "O" else values.dtype
        chunks = tuple(max(1, n) for n in values.shape)
        array = _create(group, name, values.shape, dtype, chunks, dims, attrs)
        if values.size:
            array[...] = values

    def finish(self):
        """Gives a complete store its name."""
        import zarr

        # Whoever still writes a chunk that is there already has to give up.
        _remove(self.path / WRITING, self.path.with_suffix(".writing"))
        group = zarr.open_group(str(self.path), mode="r")
        for name, array in arrays_of(group):
            gone = missing_chunks(self.path, name, array)
            if gone:
                raise InternalError(f"{self.out}: {gone} chunks of /{name} were not written; please report it")
        self.complete = True
        old = self.path.with_suffix(".old")
        try:
            self.refuse()
            if self.out.exists():
                self.out.rename(old)
            try:
                self.path.rename(self.out)
            except BaseException:
                if old.exists():
                    old.rename(self.out)
                raise
        except OSError as error:
            older = next((f", the older one {p}" for p in (old, self.out) if p.exists()), "")
            raise OutputExistsError(f"{self.out}: cannot be put in place; the complete store is {self.path}{older}: {error}") from error
        shutil.rmtree(old, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # A complete one that could not be put in its place stays, and the exception names it.
        if not self.complete and self.path.exists():
            _remove(self.path, self.path.with_suffix(".gone"))


def _remove(folder, aside):
    """Removes a folder into which others may still write: under another name, where they do not find it."""
    folder.rename(aside)
    shutil.rmtree(aside, ignore_errors=True)


def _create(group, name, shape, dtype, chunks, dims, attrs):
    import zarr

    return group.create_array(
        name,
        shape=shape,
        dtype=dtype,
        chunks=chunks,
        dimension_names=list(dims),
        attributes=attrs,
        compressors=zarr.codecs.ZstdCodec(level=1, checksum=True),
        # One folder a dataset: a chunk can be put in its place without making folders.
        chunk_key_encoding={"name": "default", "separator": "."},
        config={"write_empty_chunks": True},
    )


def write_rows(store, rec, at, rows=None):
    """Writes rows of a recording into a store that is being made, from its row `at`, a multiple of the chunk.

    Every chunk is written beside and put in its place, so that writing one twice is harmless.
    """
    import zarr
    from zarr.core.buffer import default_buffer_prototype

    rows = rec.pulses if rows is None else rows
    store = Path(store)
    for name in rec.columns:
        meta = default_buffer_prototype().buffer.from_bytes((store / name / "zarr.json").read_bytes())
        shape, step = None, 1
        first = 0
        while first < rows:
            encoded = {"zarr.json": meta}
            # Taken over by the array; a chunk of zeros is written like any other.
            with zarr.config.set({"array.write_empty_chunks": True}):
                array = zarr.open_array(zarr.storage.MemoryStore(encoded), mode="r+")
            if shape is None:
                shape = array.shape
                if at % array.chunks[0]:
                    raise ValueError(f"row {at} is no multiple of the {array.chunks[0]} pulses of a chunk")
                chunk = array.chunks[0]
                row_bytes = max(1, array.dtype.itemsize * int(np.prod(shape[1:])))
                step = max(1, CHUNK_BYTES // (row_bytes * chunk)) * chunk
            last = min(rows, first + step)
            array[at + first : at + last] = rec.read(name, (slice(first, last),) + (slice(None),) * (len(shape) - 1))
            for key, value in encoded.items():
                if key != "zarr.json":
                    beside = store / WRITING / uuid.uuid4().hex
                    beside.write_bytes(value.to_bytes())
                    os.replace(beside, store / name / key)
            first = last


def convert(
    recording: str | os.PathLike[str], out: str | os.PathLike[str], force: bool = False, chunk_pulses: int | None = None
) -> str:
    """Makes a Zarr store of a recording: an HDF5 file, a plain folder, or another store."""
    draft = Draft(out, force)
    with source(recording) as rec:
        outline = Outline.of(rec)
        chunk = chunk_pulses or chunk_length(rec.pulses, outline.row_bytes())
        with draft:
            draft.create(outline, rec.pulses, chunk)
            write_rows(draft.path, rec, 0)
            draft.finish()
    return str(draft.out)


def record(
    scene: Any,
    out: str | os.PathLike[str],
    force: bool = False,
    progress: Any = True,
    pulses: Any = None,
    chunk_pulses: int | None = None,
    scratch: str | os.PathLike[str] | None = None,
) -> str:
    """Records a scenario as a Zarr store: into an HDF5 part in the folder `scratch` first (default: beside `out`).

    Ctrl-C, a run that fails, and an exception of `progress` leave a store of the pulses so far and go on as what they
    are; without any pulse they leave what was there. A part that cannot be converted stays, and `RunError` names it.
    """
    draft = Draft(out, force)
    folder = os.path.abspath(scratch or draft.out.parent)
    kept = os.path.join(folder, f"{draft.out.stem}.{uuid.uuid4().hex[:8]}.h5")
    with tempfile.TemporaryDirectory(prefix=".nereus-", dir=folder) as folder:
        part = os.path.join(folder, "part.h5")
        try:
            scene.record(part, progress=progress, pulses=pulses)
        except BaseException:
            if _has_pulses(part):
                _convert_or_keep(part, kept, draft.out, force, chunk_pulses)
            raise
        return _convert_or_keep(part, kept, draft.out, force, chunk_pulses)


def _has_pulses(part):
    """Whether there is something to lose; of a damaged part, too."""
    try:
        with source(part) as rec:
            return rec.pulses > 0
    except FileNotFoundError:
        return False
    except InputError:
        return True


def _convert_or_keep(part, kept, out, force, chunk_pulses):
    """Makes a store of a part; where that fails, the part gets a name of its own."""
    try:
        return convert(part, out, force, chunk_pulses)
    except BaseException as error:
        os.rename(part, kept)
        text = f"{out}: not made: {str(error) or type(error).__name__}; the pulses are in {kept}: nereus.zarr.convert() makes the store of it"
        raise (RunError if isinstance(error, Exception) else KeyboardInterrupt)(text) from error
