"""Scenarios: read, changed, checked, streamed, recorded."""

from __future__ import annotations

import datetime
import html
import importlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np

from . import _nereus, progress as _progress
from ._nereus import Stream
from .arrays import ArrayFile, Folder, finite
from .errors import ArrayError, InputError, OutputExistsError, ScenarioError, existing

__all__ = ["Report", "Scenario"]

#: The first pulse, and the one after the last.
Pulses = Union[tuple[int, int], range, None]
_HDF5 = (".h5", ".hdf5")


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
            self._text = source
        elif isinstance(source, (str, os.PathLike)):
            self._path = existing(source, "scenario")
            try:
                self._text = Path(self._path).read_bytes().decode()
            except (OSError, UnicodeDecodeError):
                # The engine finds the same, and words it.
                self._text = None
                self._engine
        else:
            raise InputError(f"a scenario of {type(source).__name__}; allowed: a path, TOML text, or a dict")

    def set(self, values: Mapping[str, Any]) -> Scenario:
        """The same with other values, by dotted keys as `--set` of the command line has them.

        Entries of arrays go by number from 0 (`"target.0.rcs_m2"`), `"target.+"` appends one.

        >>> Scenario("configs/selftest.toml").set({"scene.duration_s": 1.0}).pulse_count
        222
        """
        other = object.__new__(Scenario)
        other.__dict__.update(self.__dict__)
        other._folders = list(self._folders)
        other._engine_ = None
        other._overrides = self._overrides + [
            (key, _nereus.inline_toml(json.dumps(other._plain(key, value)))) for key, value in values.items()
        ]
        return other

    def _plain(self, key: str, value: Any) -> Any:
        """A value as JSON has it; arrays that a scenario reads from files become their paths."""
        if isinstance(value, Mapping):
            return {str(name): self._plain(f"{key}.{name}".lstrip("."), item) for name, item in value.items()}
        if isinstance(value, ArrayFile):
            if not self._folders:
                self._folders.append(Folder())
            return self._folders[-1].put(value)
        if isinstance(value, (np.ndarray, np.generic)):
            if value.dtype.kind not in "biufU":
                hint = "; nereus.waveform takes complex samples" if value.dtype.kind == "c" else ""
                raise ArrayError(f"{key}: an array of {value.dtype}; allowed: numbers, truth values, texts{hint}")
            return finite(key, value).tolist() if value.dtype.kind == "f" else value.tolist()
        if isinstance(value, (list, tuple)):
            return [self._plain(f"{key}.{i}", item) for i, item in enumerate(value)]
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        if isinstance(value, datetime.datetime):
            aware = value if value.tzinfo else value.replace(tzinfo=datetime.timezone.utc)
            return aware.astimezone(datetime.timezone.utc).isoformat().replace("+00:00", "Z")
        if isinstance(value, float) and not np.isfinite(value):
            raise InputError(f"{key}: {value}; allowed: a finite number")
        if value is None:
            raise InputError(f"{key}: None takes no key away; remedy: leave it out of the file or dict that Scenario() reads")
        if not isinstance(value, (str, bool, int, float)):
            raise InputError(f"{key}: a value of {type(value).__name__}; allowed: numbers, texts, lists, dicts, arrays")
        return value

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
            raise InputError(f'pace: {pace!r}; allowed: "fast", "realtime"')
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
        path = os.fspath(path)
        suffix = os.path.splitext(path)[1].lower()
        found = format or ("hdf5" if suffix in _HDF5 else "zarr" if suffix == ".zarr" else "plain")
        if found == "zarr":
            zarr = importlib.import_module(".zarr", __package__)
            return zarr.record(self, path, pulses=pulses, progress=progress, force=force)
        if found not in ("hdf5", "plain"):
            raise InputError(f'format: {format!r}; allowed: "hdf5", "plain", "zarr"')
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
    found = tuple(pulses) if isinstance(pulses, Iterable) else ()
    if len(found) != 2 or not all(isinstance(n, (int, np.integer)) and n >= 0 for n in found):
        raise InputError(f"pulses: {pulses!r}; allowed: (first, one past the last), whole numbers from 0")
    return int(found[0]), int(found[1])
