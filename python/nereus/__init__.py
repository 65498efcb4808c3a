"""nereus: a bistatic marine radar emulator.

    import nereus

    scene = nereus.Scenario("configs/quickstart.toml").set({"sea.wind_mps": 8.0, "scene.seed": 3})
    print(scene.check())
    with scene.stream(pulses=(0, 10)) as pulses:
        for pulse in pulses:
            print(pulse.index, pulse.iq.shape, pulse.reported["aircraft"].position_m)

The engine runs in this process. SI units, angles in degrees, East-North-up; docs/python.md is the manual.
"""

from __future__ import annotations

import importlib
from enum import IntFlag
from typing import Any

from ._nereus import Antenna, Platform, Pulse, Reception, Ship, Stream, __version__
from .arrays import pattern, spectrum, targets, trajectory, waveform
from .errors import (
    ArrayError,
    InputError,
    InternalError,
    MissingFileError,
    NereusError,
    OutputExistsError,
    RecordingError,
    RunError,
    ScenarioError,
    StreamClosed,
    SweepError,
    WorkerError,
)
from .image import Image, focus
from .radials import ppi
from .scenario import Report, Scenario
from .tools import Sea, bench, receive, sea, table

__all__ = [
    "Antenna",
    "ArrayError",
    "Flag",
    "error_class",
    "Image",
    "InputError",
    "InternalError",
    "MissingFileError",
    "NereusError",
    "OutputExistsError",
    "Platform",
    "Pulse",
    "Reception",
    "RecordingError",
    "Report",
    "RunError",
    "Scenario",
    "ScenarioError",
    "Sea",
    "Ship",
    "Stream",
    "StreamClosed",
    "SweepError",
    "WorkerError",
    "__version__",
    "bench",
    "distributed",
    "focus",
    "open",
    "pattern",
    "ppi",
    "receive",
    "sea",
    "spectrum",
    "table",
    "targets",
    "trajectory",
    "waveform",
]


class Flag(IntFlag):
    """Bits of `Pulse.flags`."""

    LATE = 1
    AFTER_GAP = 2
    ADC_SATURATED = 4
    OUTSIDE_WINDOW = 8
    NAV_EXTRAPOLATED = 16
    NAV_STALE = 32
    REPORT_DROPOUT = 64


def error_class(flags: Any) -> Any:
    """Error class of pulses by their flags: 0 as asked, `n` as entry `n` of `instrument["error_classes_db"]`.

    >>> error_class(0x105)
    1
    """
    return (flags >> 8) & 7


def open(path: Any, **options: Any) -> Any:
    """Opens a recording as an `xarray.Dataset`: see `nereus.dataset.open`."""
    return importlib.import_module(".dataset", __name__).open(path, **options)


def __getattr__(name: str) -> Any:
    # What needs Dask, HDF5 or shared memory is imported when it is asked for.
    if name in ("distributed", "dataset", "reader", "shm", "zarr"):
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module 'nereus' has no attribute {name!r}")
