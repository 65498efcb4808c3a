"""Scenarios: read, changed, checked, streamed, recorded."""

from __future__ import annotations

import datetime
import html
import importlib
import itertools
import json
import os
import re
import reprlib
from collections.abc import Iterable, Mapping
from typing import Any, Literal, Union

import numpy as np

from . import _nereus, progress as _progress
from ._nereus import Stream
from .arrays import ArrayFile, Folder, finite
from .errors import ArrayError, InputError, OutputExistsError, ScenarioError, existing, text

__all__ = ["Report", "Scenario"]

#: The first pulse, and the one after the last.
Pulses = Union[tuple[int, int], range, None]
_HDF5 = (".h5", ".hdf5")
#: Bytes of the longest file that is read as a scenario; the engine refuses longer ones.
_LONGEST = 4 << 20
#: Tables and lists within each other that a scenario can have.
_DEEPEST = 50


class Report:
    """What `Scenario.check` finds: `str()` is the text of `nereus check`; a notebook shows tables."""

    def __init__(self, text: str, data: dict[str, Any]) -> None:
        self._text, self._data = text, data

    @property
    def warnings(self) -> list[str]:
        """What is valid and doubtful."""
        return list(self._data["warnings"])

    def to_dict(self) -> dict[str, Any]:
        """The report as `nereus check --json` prints it."""
        return json.loads(json.dumps(self._data))

    def __str__(self) -> str:
        return self._text.rstrip("\n")

    def __repr__(self) -> str:
        return f"<nereus.Report of {self._data['scenario']}: {len(self.warnings)} warnings>"

    def _repr_html_(self) -> str:
        parts = [f"<p>warning: {html.escape(warning)}</p>" for warning in self.warnings]
        rows: list[str] = []

        def close() -> None:
            if rows:
                parts.append("<table>" + "".join(rows) + "</table>")
                rows.clear()

        for line in self._text.splitlines():
            if not line.startswith("  "):
                close()
                parts.append(f"<h4>{html.escape(line)}</h4>")
                continue
            what, _, how = line.strip().partition("  ")
            cells = (html.escape(what), html.escape(how.strip()))
            rows.append('<tr><th style="text-align:left">{}</th><td style="text-align:left">{}</td></tr>'.format(*cells))
        close()
        return "".join(parts)


class Scenario:
    """A scenario: what is emulated.

    Args:
        source: a path; TOML text (a `str` of several lines); or a dict with the keys of a scenario, whose values may be numpy
            arrays and what `nereus.trajectory`, `targets`, `pattern`, `waveform` and `spectrum` return.
        folder: where relative paths of text and dicts begin (instead of the working directory).

    A scenario is not changed: `set` returns another one. It is read when it is first used; all its faults are one
    `ScenarioError`. It can be pickled, arrays with it.

    >>> scene = Scenario({
    ...     "scene": {"duration_s": 0.1},
    ...     "radar": {
    ...         "carrier_hz": 10e9, "sample_rate_hz": 50e6, "prf_hz": 100.0, "channels": ["VV"],
    ...         "waveform": {"kind": "lfm", "bandwidth_hz": 30e6, "pulse_s": 1e-6},
    ...         "window": {"samples": 128, "start_us": 6.0},
    ...     },
    ...     "platform": [{"name": "mast", "track": {"kind": "fixed", "position_m": [0, 0, 30]}}],
    ...     "transmitter": [{"name": "tx", "platform": "mast", "power_w": 100.0, "antenna": {"kind": "isotropic"}}],
    ...     "receiver": [{"name": "rx", "platform": "mast", "antenna": {"kind": "isotropic"}}],
    ...     "target": [{"name": "corner", "position_m": [1000.0, 0.0, 2.0], "rcs_m2": 100.0}],
    ... })
    >>> scene.pulse_count
    10
    >>> with scene.stream(pulses=(0, 2)) as stream:
    ...     [(pulse.index, pulse.iq.dtype, pulse.iq.shape) for pulse in stream]
    [(0, dtype('complex64'), (1, 128)), (1, dtype('complex64'), (1, 128))]
    """

    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any], *, folder: str | os.PathLike[str] = "") -> None:
        self._folders: list[Folder] = []
        self._overrides: list[tuple[str, str]] = []
        self._engine_: _nereus.Engine | None = None
        self._text: str | None
        if isinstance(source, Mapping):
            self._path = os.path.join(os.fspath(folder), "<dict>")
            self._text = _nereus.toml(json.dumps(self._plain("", source)))
        elif isinstance(source, str) and "\n" in source:
            self._path = os.path.join(os.fspath(folder), "<text>")
            self._text = text("a scenario", source)
        elif isinstance(source, (str, os.PathLike)):
            self._path = existing(source, "scenario")
            try:
                with open(self._path, "rb") as file:
                    found = file.read(_LONGEST + 1)
                self._text = found.decode() if len(found) <= _LONGEST else None
            except (OSError, UnicodeDecodeError):
                self._text = None
            if self._text is None:
                # The engine finds the same, and words it.
                self._engine
        else:
            raise InputError(f"a scenario of {type(source).__name__}; allowed: a path, TOML text, or a dict")

    def set(self, values: Mapping[str, Any]) -> Scenario:
        """The same with other values, by dotted keys as `--set` of the command line has them.

        Entries of arrays go by number from 0 (`"target.0.rcs_m2"`), `"target.+"` appends one.

        >>> Scenario("configs/selftest.toml").set({"scene.duration_s": 1.0}).pulse_count
        222
        """
        if not isinstance(values, Mapping):
            raise InputError(f"set: values of {type(values).__name__}; allowed: a dict of dotted keys")
        for key in values:
            if not isinstance(key, str):
                raise InputError(f'set: a key of {type(key).__name__}; allowed: a text such as "scene.duration_s"')
            text("set: a key", key)
        other = object.__new__(Scenario)
        other.__dict__.update(self.__dict__)
        other._folders = list(self._folders)
        other._engine_ = None
        other._overrides = self._overrides + [
            (key, _nereus.inline_toml(json.dumps(other._plain(key, value)))) for key, value in values.items()
        ]
        return other

    def _plain(self, key: str, value: Any, depth: int = 0) -> Any:
        """A value as JSON has it; arrays that a scenario reads from files become their paths."""
        if depth > _DEEPEST:
            raise InputError(f"{key[:60]}...: more than {_DEEPEST} tables and lists within each other; allowed: what a scenario has")
        if isinstance(value, Mapping):
            below = f"{key}.".lstrip(".")
            return {text("a key", str(name)): self._plain(f"{below}{name}", item, depth + 1) for name, item in value.items()}
        if isinstance(value, ArrayFile):
            if not self._folders:
                self._folders.append(Folder())
            return self._folders[-1].put(value)
        if isinstance(value, (np.ndarray, np.generic)):
            return self._array(key, value, depth)
        if isinstance(value, (list, tuple)):
            return [self._plain(f"{key}.{i}", item, depth + 1) for i, item in enumerate(value)]
        if isinstance(value, os.PathLike):
            return text(key, os.fsdecode(value))
        if isinstance(value, datetime.datetime):
            aware = value if value.tzinfo else value.replace(tzinfo=datetime.timezone.utc)
            try:
                return aware.astimezone(datetime.timezone.utc).isoformat().replace("+00:00", "Z")
            except OverflowError:
                raise InputError(f"{key}: {value} is in no year from 1 to 9999 in UTC") from None
        if isinstance(value, float) and not np.isfinite(value):
            raise InputError(f"{key}: {value}; allowed: a finite number")
        if value is None:
            raise InputError(f"{key}: None takes no key away; remedy: leave it out of the file or dict that Scenario() reads")
        if not isinstance(value, (str, bool, int, float)):
            raise InputError(f"{key}: a value of {type(value).__name__}; allowed: numbers, texts, lists, dicts, arrays")
        if isinstance(value, int) and not -(2**63) <= value < 2**64:
            raise InputError(f"{key}: a whole number of {value.bit_length()} bits; allowed: 64 bits")
        return text(key, value) if isinstance(value, str) else value

    def _array(self, key: str, value: Any, depth: int) -> Any:
        """An array or a scalar of numpy as lists and values."""
        if value.dtype.kind not in "biufU":
            hint = "; nereus.waveform takes complex samples" if value.dtype.kind == "c" else ""
            raise ArrayError(f"{key}: an array of {value.dtype}; allowed: numbers, truth values, texts{hint}")
        if np.ma.is_masked(value):
            raise ArrayError(f"{key}: an array with masked values; allowed: values everywhere")
        if value.dtype.kind == "U":
            return self._plain(key, value.tolist(), depth)
        if value.dtype.kind == "f":
            with np.errstate(over="ignore"):
                return finite(key, value.astype(np.float64)).tolist()
        return value.tolist()

    @property
    def _engine(self) -> _nereus.Engine:
        for folder in self._folders:
            folder.restore()
        if self._engine_ is None:
            try:
                self._engine_ = _nereus.Engine(self._text, self._path, self._overrides)
            except ScenarioError as error:
                # Lines of the text that a dict becomes are nobody's; nor has anybody given options.
                text = re.sub(r"^(.*<dict>)(:\d+){2}: ", r"\1: ", str(error), flags=re.MULTILINE)
                raise ScenarioError(re.sub(r"^--set: ", "set(): ", text, flags=re.MULTILINE), error.faults) from None
        return self._engine_

    @property
    def pulse_count(self) -> int:
        """Pulses of the run."""
        return self._engine.pulses

    @property
    def text(self) -> str:
        """The scenario as it is recorded: TOML, with what was set."""
        return self._engine.text

    def check(self) -> Report:
        """Validates the scenario, says what is modelled and what is not, and predicts error, speed and memory.

        Raises:
            ScenarioError: all faults at once.
        """
        return Report(*self._engine.check())

    def stream(self, pace: Literal["fast", "realtime"] = "fast", pulses: Pulses = None) -> Stream:
        """Starts a run and returns its pulses as they are released; sinks of the scenario are left out.

        Args:
            pace: "fast": as soon as they are made; whoever is slow holds up the run, and nothing is lost. "realtime": at their
                emission times plus `stream.latency_ms`; whoever is slow misses pulses (`Flag.AFTER_GAP`).
            pulses: first and one past the last, instead of all.
        """
        if pace not in ("fast", "realtime"):
            raise InputError(f'pace: {reprlib.repr(pace)}; allowed: "fast", "realtime"')
        return self._engine.stream(pace == "realtime", _range(pulses))

    def record(
        self,
        path: str | os.PathLike[str],
        format: Literal["hdf5", "plain", "zarr"] | None = None,
        pulses: Pulses = None,
        progress: _progress.Wanted = True,
        force: bool = False,
    ) -> dict[str, Any]:
        """Makes pulses as fast as the machine can and records them, bit-identical to `nereus run --pace fast --out`.

        Args:
            path: .h5 and .hdf5 are HDF5 files, .zarr Zarr stores, all others folders of plain files.
            format: instead of what the name says.
            pulses: first and one past the last, instead of all.
            progress: whether a progress bar is shown, or what is called with pulses passed, all pulses, late and dropped.
            force: whether a recording that exists is replaced.

        Returns what `nereus run --json` reports (docs/python.md), of a Zarr store its path. Ctrl-C ends the run; the
        recording then holds the pulses so far.

        Raises:
            OutputExistsError: `path` exists, and is not to be replaced, or no recording.
            MissingFileError: its folder does not exist.
        """
        path = text("path", os.fsdecode(path))
        suffix = os.path.splitext(path)[1].lower()
        found = format
        if format is None:
            found = "hdf5" if suffix in _HDF5 else "zarr" if suffix == ".zarr" else "plain"
        if found == "zarr":
            zarr = importlib.import_module(".zarr", __package__)
            return zarr.record(self, path, pulses=pulses, progress=progress, force=force)
        if found not in ("hdf5", "plain"):
            raise InputError(f'format: {reprlib.repr(format)}; allowed: "hdf5", "plain", "zarr"')
        existing(os.path.dirname(os.path.abspath(path)), "folder, for the output")
        if os.path.lexists(path) and not force:
            raise OutputExistsError(f"{path}: exists already; allowed: another name, or force=True, which replaces recordings")
        try:
            with _progress.shown(progress) as shows:
                return self._engine.record(path, found == "hdf5", _range(pulses), force, shows)
        except ScenarioError as error:
            if f"{path}: not overwritten" in str(error):
                raise OutputExistsError(str(error)) from None
            raise

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__, _engine_=None)
        if self._text is not None and not self._path.endswith(("<dict>", "<text>")):
            # Files that it names lie beside it.
            state["_path"] = os.path.abspath(self._path)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __repr__(self) -> str:
        changes = "".join(f", {key} = {value}" for key, value in self._overrides)
        return f"<nereus.Scenario {self._path}{changes}>"


def _range(pulses: Pulses | Iterable[int]) -> tuple[int, int] | None:
    if pulses is None:
        return None
    if isinstance(pulses, range):
        pulses = (pulses.start, pulses.stop) if pulses.step == 1 else ()
    # Not more of what is given than shows that it is too long.
    found = tuple(itertools.islice(pulses, 3)) if isinstance(pulses, Iterable) else ()
    if len(found) != 2 or not all(isinstance(n, (int, np.integer)) and 0 <= n < 2**64 for n in found):
        raise InputError(f"pulses: {reprlib.repr(pulses)}; allowed: (first, one past the last), whole numbers from 0")
    return int(found[0]), int(found[1])
