"""Images of recordings."""

from __future__ import annotations

import json
import os
import reprlib
import tempfile
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, existing, needs, unknown
from .scenario import Pulses, _range
from .tools import _command

__all__ = ["Image", "focus"]


@dataclass(frozen=True)
class Image:
    """An image by back-projection.

    Attributes:
        values: complex64 [channel, y, x], sqrt(W): the echo of a point at rest.
        x_m: middles of the pixels, East.
        y_m: middles of the pixels, North.
        channels: names of the channels.
        report: what `nereus focus --json` prints: cells, powers, how well every target is focused.
    """

    values: NDArray[np.complex64]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    channels: list[str]
    report: dict[str, Any]

    @property
    def power_db(self) -> NDArray[np.float32]:
        """Power of every pixel, dBW."""
        with np.errstate(divide="ignore"):
            return 20.0 * np.log10(np.abs(self.values))

    def plot(self, channel: str | int = 0, *, dynamic_db: float = 50.0, ax: Any = None) -> Any:
        """Draws a channel in decibels below its brightest pixel and returns matplotlib's axes."""
        plt = needs("Image.plot", "plot", "matplotlib.pyplot")
        names = dict(enumerate(self.channels))
        at = next((at for at, name in names.items() if channel in (at, at - len(names), name)), None)
        if at is None:
            raise unknown("the channel", str(channel), self.channels)
        power = self.power_db[at]
        ax = ax or plt.subplots()[1]
        extent = [float(v) for axis in (self.x_m, self.y_m) for v in _edges(axis)]
        top = float(power.max())
        drawn = ax.imshow(power - top, origin="lower", extent=extent, vmin=-dynamic_db, vmax=0.0, cmap="gray")
        ax.set(xlabel="East, m", ylabel="North, m", title=f"{self.channels[at]}, {self.report['nav']} navigation")
        ax.figure.colorbar(drawn, ax=ax, label=f"dB below {top:.1f} dBW")
        return ax

    def to_xarray(self) -> Any:
        """The same as an `xarray.DataArray`."""
        xarray = needs("Image.to_xarray", "xarray", "xarray")
        coords = {"channel": self.channels, "y_m": self.y_m, "x_m": self.x_m}
        return xarray.DataArray(self.values, coords, ("channel", "y_m", "x_m"), "image", {"units": "sqrt(W)"})


def _edges(axis: NDArray[np.float64]) -> tuple[float, float]:
    half = 0.5 * (axis[1] - axis[0]) if axis.size > 1 else 0.5
    return axis[0] - half, axis[-1] + half


def focus(
    recording: Any,
    nav: Literal["true", "reported"] = "reported",
    *,
    pulses: Pulses = None,
    channel: list[str] | str | None = None,
    centre_m: tuple[float, float] | None = None,
    size_m: float | tuple[float, float] = 512.0,
    pixel_m: float = 1.0,
    **options: Any,
) -> Image:
    """Makes an image of a recording, as `nereus focus` does.

    Args:
        recording: a path, or a dataset of `nereus.open`, whose file is read again: of it the pulses and channels that
            the dataset has. Samples and navigation of the dataset are compared with the file, which is the only one
            that is focused: where they were cut or changed, that is refused. Changes of all else are not seen.
        nav: which navigation the processor takes.
        pulses: first and one past the last, instead of all; not of a dataset in which some are selected.
        channel: instead of all channels of echoes; not of a dataset in which some are selected.
        centre_m: middle of the image, East and North, instead of where the radar looks at the middle one of the pulses:
            give it where images of several parts are compared.
        size_m: sides of the image.
        pixel_m: distance of pixels.
        options: further options of the command: `window`, `aperture`, `doppler_hz`, `filter`, `height_m`.
    """
    h5py = needs("nereus.focus", "xarray", "h5py")
    if nav not in ("true", "reported"):
        raise InputError(f'nav: {reprlib.repr(nav)}; allowed: "true", "reported"')
    path = _path(recording)
    given: dict[str, Any] = {"pulses": _range(pulses), "channel": channel}
    if getattr(recording, "encoding", None):
        for name, value in _selected(recording, path).items():
            if given[name] is not None:
                raise InputError(f"{name}: {given[name]!r}, of a dataset in which some are selected; allowed: one of both")
            given[name] = value
    if given["pulses"] is not None:
        given["pulses"] = "{}..{}".format(*given["pulses"])
    options.update(given, nav=nav, centre_m=centre_m, size_m=size_m, pixel_m=pixel_m)
    with tempfile.TemporaryDirectory(prefix="nereus-") as folder:
        out = os.path.join(folder, "image.h5")
        report = json.loads(_command(("focus",), [path, "--json", f"--out={out}"], options))
        report.pop("out", None)
        with h5py.File(out) as file:
            values = [np.asarray(file[name]) for name in ("image", "x_m", "y_m")]
    return Image(*values, channels=[row["name"] for row in report["channels"]], report=report)


def _path(recording: Any) -> str:
    source = recording
    if not isinstance(recording, (str, os.PathLike)):
        source = getattr(recording, "encoding", {}).get("source")
    if not source:
        what = type(recording).__name__
        raise InputError(f"a recording of {what}; allowed: a path, or a dataset of nereus.open")
    path = existing(source, "recording")
    if os.path.exists(os.path.join(path, "zarr.json")):
        raise InputError(f"{path}: focus reads no Zarr store; remedy: record an HDF5 file or a folder")
    return path


def _selected(recording: Any, path: str) -> dict[str, Any]:
    """Pulses, first and one past the last, and channels of a dataset, where it has not all that its file has."""
    from . import dataset

    found: dict[str, Any] = {}
    with dataset.open(path) as whole:
        wanted, recorded = (np.atleast_1d(ds.pulse.values).astype(np.int64) for ds in (recording, whole))
        channels, names = (np.atleast_1d(ds.channel.values).astype(str).tolist() for ds in (recording, whole))
        first = int(np.searchsorted(recorded, wanted[0])) if wanted.size else 0
        if wanted.size == 0 or not np.array_equal(wanted, recorded[first : first + wanted.size]):
            raise InputError(
                f"{path}: {wanted.size} pulses selected; allowed: all that are recorded from one pulse to another, at least one"
            )
        if wanted.size < recorded.size:
            found["pulses"] = int(wanted[0]), int(wanted[-1]) + 1
        if channels != names:
            found["channel"] = channels
        for name in set(channels) - set(names):
            raise unknown("the channel", name, names)
        part = whole.isel(pulse=slice(first, first + wanted.size), channel=[names.index(name) for name in channels])
        for name in ("iq", *(name for name in recording.data_vars if name.startswith("nav/") and name in whole)):
            _unchanged(path, recording.get(name), part[name])
    return found


def _unchanged(path: str, ours: Any, recorded: Any) -> None:
    """Refuses a variable that is not what the file has."""
    allowed = "allowed: what was recorded, of which pulses and channels are selected: the file is what is focused"
    if ours is None:
        raise InputError(f"{path}: {recorded.name} is not in the dataset; {allowed}")
    ours = ours.expand_dims([dim for dim in ("pulse", "channel") if dim in recorded.dims and dim not in ours.dims])
    if dict(ours.sizes) != dict(recorded.sizes):
        raise InputError(f"{path}: {recorded.name} of {dict(ours.sizes)}, recorded {dict(recorded.sizes)}; {allowed}")
    ours = ours.transpose(*recorded.dims)
    for at in range(0, recorded.sizes["pulse"], 256):
        rows = slice(at, at + 256)
        if not np.array_equal(ours[rows].values, recorded[rows].values, equal_nan=True):
            raise InputError(f"{path}: {recorded.name} was changed; {allowed}")
