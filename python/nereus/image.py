"""Images of recordings."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _nereus
from .errors import InputError
from .tools import _words

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
        import matplotlib.pyplot as plt

        at = self.channels.index(channel) if isinstance(channel, str) else channel
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
        import xarray

        coords = {"channel": self.channels, "y_m": self.y_m, "x_m": self.x_m}
        return xarray.DataArray(self.values, coords, ("channel", "y_m", "x_m"), "image", {"units": "sqrt(W)"})


def _edges(axis: NDArray[np.float64]) -> tuple[float, float]:
    half = 0.5 * (axis[1] - axis[0]) if axis.size > 1 else 0.5
    return axis[0] - half, axis[-1] + half


def focus(
    recording: Any,
    nav: Literal["true", "reported"] = "reported",
    *,
    pulses: tuple[int, int] | None = None,
    channel: list[str] | str | None = None,
    centre_m: tuple[float, float] | None = None,
    size_m: float | tuple[float, float] = 512.0,
    pixel_m: float = 1.0,
    **options: Any,
) -> Image:
    """Makes an image of a recording, as `nereus focus` does.

    Args:
        recording: a path, or a dataset of `nereus.open`, whose file is read again: of it the pulses and channels that
            the dataset has.
        nav: which navigation the processor takes.
        pulses: first and one past the last, instead of all.
        channel: instead of all channels of echoes.
        centre_m: middle of the image, East and North, instead of where the radar looks.
        size_m: sides of the image.
        pixel_m: distance of pixels.
        options: further options of the command: `window`, `aperture`, `doppler_hz`, `filter`, `height_m`.
    """
    import h5py

    if nav not in ("true", "reported"):
        raise InputError(f'nav: {nav!r}; allowed: "true", "reported"')
    path = _path(recording)
    if getattr(recording, "encoding", None):
        selected = _selected(recording, path)
        pulses, channel = pulses or selected[0], channel or selected[1]
    if pulses is not None:
        options["pulses"] = f"{pulses[0]}..{pulses[1]}"
    options.update(nav=nav, channel=channel, centre_m=centre_m, size_m=size_m, pixel_m=pixel_m)
    with tempfile.TemporaryDirectory(prefix="nereus-") as folder:
        out = os.path.join(folder, "image.h5")
        words = ["focus", path, "--json", f"--out={out}", *_words(options)]
        report = json.loads(bytes(_nereus.command(words)))
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
    path = os.fspath(source)
    if os.path.exists(os.path.join(path, "zarr.json")):
        raise InputError(f"{path}: focus reads no Zarr store; remedy: record an HDF5 file or a folder")
    return path


def _selected(recording: Any, path: str) -> tuple[tuple[int, int] | None, list[str] | None]:
    """Pulses, first and one past the last, and channels of a dataset, where it has not all that its file has."""
    from . import dataset

    with dataset.open(path) as whole:
        wanted, recorded = (np.atleast_1d(ds.pulse.values).astype(np.int64) for ds in (recording, whole))
        channels, names = (np.atleast_1d(ds.channel.values).astype(str).tolist() for ds in (recording, whole))
    pulses = None
    if not np.array_equal(wanted, recorded):
        if wanted.size == 0 or not np.array_equal(wanted, recorded[np.searchsorted(recorded, wanted[0]) :][: wanted.size]):
            raise InputError(
                f"{path}: {wanted.size} pulses selected; allowed: all that are recorded from one pulse to another, at least one"
            )
        pulses = int(wanted[0]), int(wanted[-1]) + 1
    return pulses, None if channels == names else channels
