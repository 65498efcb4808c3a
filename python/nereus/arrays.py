"""Parts of a scenario given as numpy arrays.

The functions here return tables of a scenario, for values of a dict or of `Scenario.set`. Targets become tables in memory.
Trajectories, waveforms, antenna patterns and spectra become files of the formats that a scenario reads, in a temporary folder
that lives as long as the `Scenario`. Every value keeps all its digits.
"""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import tempfile
import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import ArrayError

__all__ = ["pattern", "spectrum", "targets", "trajectory", "waveform"]


@dataclass(frozen=True)
class ArrayFile:
    """The text of a file that a scenario will name by its path."""

    name: str
    text: str


class Folder:
    """Files of arrays, in a folder that is removed with the last scenario that names them."""

    def __init__(self) -> None:
        self.path = tempfile.mkdtemp(prefix="nereus-")
        self._texts: dict[str, str] = {}
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)

    def put(self, file: ArrayFile) -> str:
        """Writes a file and returns its path; the same content has the same path."""
        digest = hashlib.sha256(file.text.encode()).hexdigest()[:16]
        path = os.path.join(self.path, f"{file.name}-{digest}.csv")
        self._texts[path] = file.text
        self.restore()
        return path

    def restore(self) -> None:
        """Writes what is missing: temporary folders are cleaned by other programs, too."""
        for path, text in self._texts.items():
            if not os.path.exists(path):
                os.makedirs(self.path, mode=0o700, exist_ok=True)
                partial = f"{path}.{os.getpid()}"
                Path(partial).write_text(text, encoding="utf-8")
                os.replace(partial, path)

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path, "_texts": self._texts}

    def __setstate__(self, state: dict[str, Any]) -> None:
        # In another process the files have the same paths, so that recordings hold the same text. Where they were missing, as
        # on another machine, they are removed at the end.
        self.__dict__.update(state)
        if not os.path.exists(self.path):
            weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)
        self.restore()


def real(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """An array of finite numbers of a shape in which None may be any length."""
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise ArrayError(f"{name}: an array of {array.dtype}; allowed: real numbers (float64)")
    return finite(name, shaped(name, array, shape).astype(np.float64))


def shaped(name: str, array: NDArray[Any], shape: tuple[int | None, ...]) -> NDArray[Any]:
    fits = array.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, array.shape))
    if not fits:
        allowed = ", ".join("n" if n is None else str(n) for n in shape)
        raise ArrayError(f"{name}: an array of shape {list(array.shape)}; allowed: [{allowed}]")
    return array


def finite(name: str, array: NDArray[Any]) -> NDArray[Any]:
    bad = ~np.isfinite(array)
    if bad.any():
        place = [int(i) for i in np.argwhere(bad)[0]]
        raise ArrayError(f"{name}: {array[tuple(place)]} at {place}; allowed: finite numbers")
    return array


def increasing(name: str, array: NDArray[Any]) -> NDArray[Any]:
    if array.size == 0:
        raise ArrayError(f"{name}: is empty; allowed: at least one value")
    falls = np.flatnonzero(array[1:] <= array[:-1])
    if falls.size:
        at = int(falls[0]) + 1
        raise ArrayError(f"{name}: {array[at]} at [{at}] follows {array[at - 1]}; allowed: strictly increasing values")
    return array


def csv(name: str, header: str | None, columns: list[NDArray[np.float64]]) -> ArrayFile:
    text = io.StringIO()
    if header is not None:
        text.write(header + "\n")
    np.savetxt(text, np.column_stack(columns), fmt="%.17g", delimiter=",")
    return ArrayFile(name, text.getvalue())


def _unix_text(time: ArrayLike) -> list[str]:
    """Times as decimal seconds since 1970, all digits kept."""
    array = np.asarray(time)
    if array.ndim != 1:
        raise ArrayError(f"time: an array of shape {list(array.shape)}; allowed: [n]")
    if array.dtype.kind == "M":
        if np.isnat(array).any():
            place = int(np.flatnonzero(np.isnat(array))[0])
            raise ArrayError(f"time: NaT at [{place}]; allowed: UTC times")
        ns = increasing("time", array.astype("datetime64[ns]")).astype(np.int64)
        return [f"{'-' if n < 0 else ''}{abs(n) // 10**9}.{abs(n) % 10**9:09d}" for n in ns.tolist()]
    seconds = increasing("time", real("time", array, (None,)))
    return [np.format_float_positional(s, trim="-") for s in seconds]


def trajectory(
    time: ArrayLike,
    position_m: ArrayLike | None = None,
    *,
    position_llh: ArrayLike | None = None,
    attitude_deg: ArrayLike | None = None,
    **keys: Any,
) -> dict[str, Any]:
    """A track of a platform from arrays: a table for `platform.N.track` or `platform.N.reported`.

    Args:
        time: UTC of the fixes, [n], increasing: `datetime64`, or seconds since 1970.
        position_m: East, North, up in the scene frame, [n, 3], m; or
        position_llh: latitude, longitude (deg, WGS-84), height (m), [n, 3], with the key `datum`.
        attitude_deg: roll (right wing down), pitch (nose up), heading (clockwise from North), [n, 3]. Without it the
            attitude is that of a coordinated turn.
        keys: further keys of `[platform.track]`: `max_gap_s`, `smoothing`, `attitude`, `datum`.

    The scene needs `scene.start_utc` within the track. Becomes a CSV file in a temporary folder.

    >>> track = trajectory([0.0, 1.0, 2.0], [[0, 0, 300], [0, 60, 300], [0, 120, 300]])
    >>> track["kind"]
    'csv'
    >>> trajectory([0.0, 2.0, 1.0], [[0, 0, 300]] * 3)
    Traceback (most recent call last):
        ...
    nereus.errors.ArrayError: time: 1.0 at [2] follows 2.0; allowed: strictly increasing values
    """
    times = _unix_text(time)
    if (position_m is None) == (position_llh is None):
        raise ArrayError("trajectory: allowed: exactly one of position_m and position_llh")
    if position_m is not None:
        header, position = "x_m,y_m,z_m", real("position_m", position_m, (len(times), 3))
    else:
        header, position = "lat_deg,lon_deg,height_m", real("position_llh", np.asarray(position_llh), (len(times), 3))
    columns = [position]
    header = "unix_s," + header
    if attitude_deg is not None:
        columns.append(real("attitude_deg", attitude_deg, (len(times), 3)))
        header += ",roll_deg,pitch_deg,yaw_deg"
    rows = csv("track", None, columns).text.splitlines()
    lines = [header] + [f"{time},{row}" for time, row in zip(times, rows)]
    return {"kind": "csv", "path": ArrayFile("track", "\n".join(lines) + "\n"), **keys}


def waveform(samples: ArrayLike, rate_hz: float) -> dict[str, Any]:
    """A transmitted pulse from its samples, [n], real or complex, at a rate: a table for `radar.waveform`.

    Between the samples the pulse is band-limited to the rate. Becomes a CSV file in a temporary folder.

    >>> import numpy as np
    >>> waveform(np.ones(16, np.complex64), 50e6)["rate_hz"]
    50000000.0
    """
    array = np.asarray(samples)
    if array.dtype.kind not in "iufc":
        raise ArrayError(f"samples: an array of {array.dtype}; allowed: numbers (complex64 or complex128)")
    array = finite("samples", shaped("samples", array, (None,)).astype(np.complex128))
    return {"kind": "file", "path": csv("waveform", None, [array.real, array.imag]), "rate_hz": float(rate_hz)}


def pattern(
    azimuth_deg: ArrayLike, elevation_deg: ArrayLike, gain_dbi: ArrayLike, phase_deg: ArrayLike | None = None, **keys: Any
) -> dict[str, Any]:
    """A measured antenna pattern: a table for `antenna` of a transmitter or receiver.

    Args:
        azimuth_deg: in the antenna frame, [a], regular and increasing.
        elevation_deg: [e], regular and increasing.
        gain_dbi: [a, e], dBi.
        phase_deg: [a, e]; without it side lobes do not change sign.
        keys: further keys of the antenna.

    Becomes a CSV file in a temporary folder.

    >>> import numpy as np
    >>> pattern([-1.0, 0.0, 1.0], [-1.0, 1.0], np.zeros((3, 2)))["kind"]
    'file'
    """
    azimuth = increasing("azimuth_deg", real("azimuth_deg", azimuth_deg, (None,)))
    elevation = increasing("elevation_deg", real("elevation_deg", elevation_deg, (None,)))
    shape = (azimuth.size, elevation.size)
    columns = [*np.meshgrid(azimuth, elevation, indexing="ij"), real("gain_dbi", gain_dbi, shape)]
    header = "az_deg,el_deg,gain_dbi"
    if phase_deg is not None:
        columns.append(real("phase_deg", phase_deg, shape))
        header += ",phase_deg"
    return {"kind": "file", "path": csv("pattern", header, [c.ravel() for c in columns]), **keys}


def spectrum(kx_rad_m: ArrayLike, ky_rad_m: ArrayLike, psi_m4: ArrayLike) -> dict[str, Any]:
    """A measured spectrum of the sea: keys for `[sea]`, beside `wind_mps` and the others.

    Args:
        kx_rad_m: wave numbers East, in the direction of travel, [x], regular and increasing.
        ky_rad_m: wave numbers North, [y].
        psi_m4: density, [x, y], 0 or more.

    Becomes a CSV file in a temporary folder.

    >>> sorted(spectrum([0.0, 1.0], [0.0, 1.0], [[0.0, 0.0], [4.0, 2.0]]))
    ['spectrum', 'spectrum_path']
    """
    kx = increasing("kx_rad_m", real("kx_rad_m", kx_rad_m, (None,)))
    ky = increasing("ky_rad_m", real("ky_rad_m", ky_rad_m, (None,)))
    psi = real("psi_m4", psi_m4, (kx.size, ky.size))
    if (psi < 0).any():
        place = [int(i) for i in np.argwhere(psi < 0)[0]]
        raise ArrayError(f"psi_m4: {psi[tuple(place)]} at {place}; allowed: 0 or more")
    columns = [c.ravel() for c in (*np.meshgrid(kx, ky, indexing="ij"), psi)]
    return {"spectrum": "measured", "spectrum_path": csv("spectrum", "kx_rad_m,ky_rad_m,psi_m4", columns)}


def targets(
    position_m: ArrayLike, rcs_m2: ArrayLike, *, velocity_mps: ArrayLike | None = None, name: str = "target"
) -> list[dict[str, Any]]:
    """Point targets from arrays: the tables for `target`, in memory.

    Args:
        position_m: East, North, height above the sea, [n, 3].
        rcs_m2: radar cross section, [n] or one for all.
        velocity_mps: [n, 3] or [3] for all.
        name: what their names begin with; a number from 0 follows.

    >>> [target["name"] for target in targets([[0, 0, 2], [10, 0, 2]], 5.0)]
    ['target0', 'target1']
    """
    position = real("position_m", position_m, (None, 3))
    count = len(position)
    rcs = np.asarray(rcs_m2)
    rcs = real("rcs_m2", np.broadcast_to(rcs, (count,)) if rcs.ndim == 0 else rcs, (count,))
    tables = [
        {"name": f"{name}{i}", "position_m": p, "rcs_m2": r}
        for i, (p, r) in enumerate(zip(position.tolist(), rcs.tolist()))
    ]
    if velocity_mps is not None:
        velocity = np.asarray(velocity_mps)
        velocity = real("velocity_mps", np.broadcast_to(velocity, (count, 3)) if velocity.shape == (3,) else velocity, (count, 3))
        for table, v in zip(tables, velocity.tolist()):
            table["velocity_mps"] = v
    return tables
