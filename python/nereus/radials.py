"""Plan position of recordings of a scanning radar: power over azimuth and range."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, needs, unknown

if TYPE_CHECKING:
    import xarray

__all__ = ["ppi"]

_HALF_C_MPS = 299_792_458.0 / 2.0
#: Samples that are compressed at a time, bytes.
_BLOCK_BYTES = 32 << 20
#: Steps of azimuth that are allowed, degrees.
_STEPS_DEG = (0.05, 90.0)
_POLARISATIONS = {"H": 1, "V": 2, "R": 3, "L": 4}


def ppi(
    ds: xarray.Dataset,
    channel: str | None = None,
    *,
    azimuth_step_deg: float = 1.0,
    pointing: Literal["reported", "true"] = "reported",
) -> xarray.DataArray:
    """Range-compressed power of a scanning radar over azimuth and range.

    Each pulse `s[i]` of the channel is compressed with the recorded replica `q`, and powers are averaged over the
    pulses `p` of a step of azimuth:

        y_p[j] = sum_i s_p[j + i] conj(q[i]) / sum_i |q[i]|^2        sqrt(W)
        P[a, j] = mean over p of |y_p[j]|^2                          W

    Cell `j` of a window that opens `t_w` after the emission has the slant range `c/2 (t_w + j/fs)`. So an echo of
    the power A on a whole sample has the power A at its range; one between two samples has less. There is no taper:
    side lobes of a linear sweep are 13 dB below its peak. Where windows move, cells are those of one grid, and each
    pulse lies within half a cell.

    Args:
        ds: a dataset of `nereus.open`, or pulses and channels selected from it; the first sample has to be there.
        channel: its name; without one, the first of echoes whose receiver scans on the platform of its transmitter.
        azimuth_step_deg: width of a step, 0.05 to 90 degrees; taken so that a turn has a whole number of them.
        pointing: "reported": what the encoder reads, plus the heading that the platform reports where it counts from
            the nose. "true": the true axis of the receiving antenna.

    Returns a float64 DataArray [azimuth, range] in W. `azimuth` is the middle of each step, clockwise from North
    (ENU), 0 to 360 degrees, and the first middle is 0. `range` is in metres. Azimuths without a pulse are NaN.
    Attributes: `channel`, `pointing`, `pulses`. Turns are averaged: select pulses (`ds.sel(pulse=...)`) for one.

    Raises:
        InputError: another argument; no such channel; a receiver that does not scan, or on another platform than
            the transmitter; continuous or dechirped reception; a dataset without description, replica or pulses.
        RecordingError: samples that are damaged, found when they are read.
        ImportError: xarray is missing.
    """
    xr = needs("nereus.ppi", "xarray", "xarray")
    steps = _steps(azimuth_step_deg)
    if pointing not in ("reported", "true"):
        raise InputError(f'pointing: {pointing!r}; allowed: "reported", "true"')
    instrument = _instrument(ds)
    name, look = _channel(ds, instrument, channel)
    row = _rows(ds)[name]
    replica = np.asarray(ds["replica"].values, np.complex128)
    seen = np.flatnonzero(np.isin(ds["pulse/tx_pol"].values, (0, _POLARISATIONS.get(row["polarisations"][1:2], 0))))
    if seen.size == 0:
        raise InputError(f"channel {name}: no pulse left in its polarisation; allowed: a dataset with pulses of it")
    azimuth_deg = _azimuths(ds, row, look, pointing)[seen]
    place = np.floor(azimuth_deg * (steps / 360.0) + 0.5).astype(int) % steps
    rate_hz = float(ds.attrs["sample_rate_hz"])
    starts_s = _starts(ds, row["receiver"])[seen]
    offsets = np.rint((starts_s - starts_s.min()) * rate_hz).astype(int)
    iq = ds["iq"].sel(channel=name) if "channel" in ds["iq"].dims else ds["iq"]
    samples = iq.sizes["sample"]
    cells = samples + int(offsets.max())
    sums, counts = np.zeros((steps, cells)), np.zeros((steps, cells))
    pulses = _in_turn(instrument, replica)
    length = 1 << int(samples + pulses.shape[1] - 1).bit_length()
    weights = np.conj(np.fft.fft(pulses, length)) / np.sum(np.abs(pulses) ** 2, axis=1, keepdims=True)
    turns = ds["pulse"].values[seen] % len(pulses)
    block = max(1, _BLOCK_BYTES // (16 * length))
    for first in range(0, seen.size, block):
        part = slice(first, first + block)
        window = np.asarray(iq.isel(pulse=seen[part]).values, np.complex128)
        power = np.abs(np.fft.ifft(np.fft.fft(window, length) * weights[turns[part]])[:, :samples]) ** 2
        for values, at, offset in zip(power, place[part], offsets[part]):
            sums[at, offset : offset + samples] += values
            counts[at, offset : offset + samples] += 1.0
    mean = np.divide(sums, counts, out=np.full_like(sums, np.nan), where=counts > 0.0)
    range_m = _HALF_C_MPS * (starts_s.min() + np.arange(cells) / rate_hz)
    coords = {
        "azimuth": ("azimuth", np.arange(steps) * 360.0 / steps, {"units": "degrees", "long_name": "clockwise from North"}),
        "range": ("range", range_m, {"units": "m", "long_name": "slant range"}),
    }
    attrs = {"units": "W", "long_name": "range-compressed power", "channel": name, "pointing": pointing}
    return xr.DataArray(mean, coords, ("azimuth", "range"), "power", {**attrs, "pulses": int(seen.size)})


def _in_turn(instrument: dict[str, Any], replica: np.ndarray) -> np.ndarray:
    """The pulses that leave in turn, [pulse, sample]; mostly one."""
    turns = max(1, len(instrument["waveform"].get("pulses", ())))
    if replica.size % turns:
        raise InputError(f"ds: {turns} pulses in turn in a replica of {replica.size}; allowed: all of the recorded replica")
    return replica.reshape(turns, -1)


def _steps(azimuth_step_deg: Any) -> int:
    """Steps of a turn."""
    least, most = _STEPS_DEG
    try:
        step = float(azimuth_step_deg)
    except (TypeError, ValueError):
        step = float("nan")
    if not least <= step <= most:
        raise InputError(f"azimuth_step_deg: {azimuth_step_deg!r}; allowed: {least} to {most:g} degrees")
    return max(4, round(360.0 / step))


def _instrument(ds: xarray.Dataset) -> dict[str, Any]:
    """The radar of a recording whose pulses can be compressed."""
    missing = [name for name in ("iq", "replica", "pulse/tx_pol", "channel/receiver") if name not in getattr(ds, "variables", ())]
    if missing or not ds.attrs.get("instrument"):
        raise InputError(f"ds: has no {missing[0] if missing else 'attribute instrument'}; allowed: a dataset of nereus.open")
    if ds.sizes.get("pulse", 0) == 0 or ds["replica"].size == 0:
        raise InputError("ds: has no pulse, or no replica; allowed: a recording with both")
    instrument: dict[str, Any] = json.loads(ds.attrs["instrument"])
    for key, words in (("continuous", "blocks received without a gap"), ("dechirp_s", "dechirped echoes")):
        if instrument.get(key) not in (None, False):
            raise InputError(f"ds: holds {words}; allowed: a recording with a window for every pulse, not dechirped")
    return instrument


def _rows(ds: xarray.Dataset) -> dict[str, dict[str, str]]:
    """Receiver, transmitter and polarisations of channels by their names."""
    keys = ("transmitter", "receiver", "polarisations")
    columns = [np.atleast_1d(ds[f"channel/{key}"].values) for key in keys]
    return {str(name): dict(zip(keys, map(str, row))) for name, *row in zip(np.atleast_1d(ds["channel"].values), *columns)}


def _channel(ds: xarray.Dataset, instrument: dict[str, Any], asked: str | None) -> tuple[str, dict[str, Any]]:
    """The channel, and how its receiver scans."""
    antennas = {antenna["name"]: antenna for antenna in instrument["antennas"]}
    rows = {name: row for name, row in _rows(ds).items() if len(row["polarisations"]) == 2}
    if asked is not None and asked not in rows:
        raise unknown("the channel", str(asked), rows)
    for name in rows if asked is None else [asked]:
        ends = [antennas.get(rows[name][end], {}) for end in ("transmitter", "receiver")]
        look = ends[1].get("look", {})
        if look.get("kind") == "scan" and ends[0].get("platform") == ends[1].get("platform"):
            return name, look
    raise InputError(
        f"channel {asked or ', '.join(rows) or 'none'}: its receiver does not scan on the platform of its transmitter; "
        'allowed: channels whose receiver has pointing.kind = "scan" or "sector" there'
    )


def _azimuths(ds: xarray.Dataset, row: dict[str, str], look: dict[str, Any], pointing: str) -> NDArray[np.float64]:
    """Azimuth of every pulse, degrees from North."""
    if pointing == "true":
        name = f"nav/{row['receiver']}/boresight_quat"
        if name not in ds or not bool(ds.attrs.get("truth", True)):
            raise InputError('pointing: "true", of a recording without truth; allowed: "reported"')
        return _heading_deg(ds[name].values)
    encoder = np.asarray(ds[f"nav/{row['receiver']}/encoder_deg"].values)[:, 0]
    if look["level"]:
        return encoder
    platform = next(a["platform"] for a in json.loads(ds.attrs["instrument"])["antennas"] if a["name"] == row["receiver"])
    return encoder + _heading_deg(ds[f"nav/{platform}/reported/attitude_quat"].values)


def _heading_deg(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where the x axis of frames looks, clockwise from North, degrees; quaternions w, x, y, z to ENU."""
    w, x, y, z = np.moveaxis(np.asarray(quaternion, np.float64), -1, 0)
    return np.degrees(np.arctan2(w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z)))


def _starts(ds: xarray.Dataset, receiver: str) -> NDArray[np.float64]:
    """Start of the window of a receiver after each emission, s."""
    if "pulse/receiver_window_start_s" in ds:
        names = [str(name) for name in np.atleast_1d(ds.attrs["receivers"])]
        return np.asarray(ds["pulse/receiver_window_start_s"].values)[:, names.index(receiver)]
    return np.asarray(ds["pulse/window_start_s"].values)
