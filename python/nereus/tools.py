"""Commands of the program that return arrays: tables of models, the sea, benchmarks, a receiver."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _nereus
from ._nereus import Reception
from .errors import InputError, needs, unknown
from .scenario import Scenario

__all__ = ["Sea", "bench", "receive", "sea", "table"]


#: Options that are for files, pictures and terminals.
_NO_KEYWORDS = {"against", "cuts", "dynamic_db", "force", "help", "json", "out", "panels", "percentile"}


@lru_cache(maxsize=None)
def _listed(command: tuple[str, ...], pattern: str) -> frozenset[str]:
    """Names that the help of a command lists."""
    try:
        _nereus.command([*command, "--help"])
    except InputError as text:
        return frozenset(re.findall(pattern, str(text), re.MULTILINE))
    return frozenset()


def _command(command: tuple[str, ...], words: list[str], options: Mapping[str, Any], text: str | None = None) -> str:
    """What a command prints that has keywords as options; its faults in words of Python."""
    allowed = {name.replace("-", "_") for name in _listed(command, r"^ {2,6}(?:-\w, )?--([\w-]+)")} - _NO_KEYWORDS
    for name in options.keys() - allowed:
        raise unknown(f"{command[0]}: the keyword", name, allowed)
    try:
        return bytes(_nereus.command([*command, *words, *_words(options)], text)).decode()
    except InputError as error:
        if type(error) is not InputError:
            raise
        text = str(error).removeprefix("error: ").split("\n\n")[0]
        text = re.sub(r"\s*\[possible values: (.*)\]", r"; allowed: \1", text)
        text = re.sub(r"(?<!\S)'?--([a-z][\w-]*)(?: <[^>]*>)?'?", lambda option: option[1].replace("-", "_"), text)
        raise InputError(text) from None


def _words(options: Mapping[str, Any]) -> list[str]:
    """Options of the command line from keywords."""
    words: list[str] = []
    for name, value in options.items():
        if value is None or value is False:
            continue
        flag = "--" + name.replace("_", "-")
        if value is True:
            words.append(flag)
            continue
        values = np.atleast_1d(np.asarray(value)).tolist()
        for item in values:
            if isinstance(item, (Mapping, list, tuple, set, frozenset)):
                raise InputError(f"{name}: a value of {type(item).__name__}; allowed: numbers, texts, lists of these")
        words.append(f"{flag}={','.join(str(item) for item in values)}")
    return words


def table(quantity: str, **keys: Any) -> dict[str, NDArray[Any]]:
    """A table of a model, as `nereus table` prints it: an array for each column.

    `quantity` and the keys are those of the command (docs/commands.md); a list makes rows for each of its values.

    >>> rows = table("sigma0", wind_mps=[5, 10], vary="incidence")
    >>> sorted(set(rows["u10_mps"].tolist())), rows["sigma0_vv_db"].shape == rows["incidence_deg"].shape
    ([5.0, 10.0], True)
    """
    if not isinstance(quantity, str):
        raise InputError(f"table: a quantity of {type(quantity).__name__}; allowed: a text")
    quantities = _listed(("table",), r"^  ([a-z][\w-]*) ")
    if quantity not in quantities:
        raise unknown("table: the quantity", quantity, quantities)
    text = _command(("table", quantity), [], keys)
    rows = list(csv.reader(line for line in io.StringIO(text) if not line.startswith("#")))
    columns = {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}
    return {name: _column(values) for name, values in columns.items()}


def _column(values: list[str]) -> NDArray[Any]:
    try:
        return np.array([float(value) if value else np.nan for value in values])
    except ValueError:
        return np.array(values)


def bench(
    scene: Scenario, *, pulses: int | None = None, threads: int | None = None, error_pulses: int | str = 16
) -> dict[str, Any]:
    """Measures speed, memory and error of a scenario on this machine: what `nereus bench --json` prints."""
    options = {"pulses": pulses, "threads": threads, "error_pulses": error_pulses}
    return json.loads(_command(("bench",), [scene._path, "--json"], options, scene.text))


@dataclass(frozen=True)
class Sea:
    """The sea at an instant. `sea["height_m"]` is a field, [y, x]; `figures` are those of `nereus sea --json`."""

    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    fields: dict[str, NDArray[np.float64]]
    units: dict[str, str]
    figures: dict[str, Any]

    def __getitem__(self, field: str) -> NDArray[np.float64]:
        return self.fields[field]

    def to_xarray(self) -> Any:
        """The same as an `xarray.Dataset`."""
        xarray = needs("Sea.to_xarray", "xarray", "xarray")
        data = {name: (("y_m", "x_m"), values, {"units": self.units[name]}) for name, values in self.fields.items()}
        return xarray.Dataset(data, {"y_m": self.y_m, "x_m": self.x_m}, self.figures)


def sea(scene: Scenario, time_s: float = 0.0) -> Sea:
    """The sea of a scenario at a time after pulse 0: heights, slopes, velocities, displacements of all facets.

    >>> water = sea(Scenario("configs/sea.toml").set({"scene.patch_size_m": [64.0, 64.0], "scene.facet_m": 2.0}))
    >>> water["height_m"].shape
    (32, 32)
    """
    return Sea(*scene._engine.sea(time_s))


def receive(
    address: str = "127.0.0.1:4991",
    *,
    pulses: int | None = None,
    duration_s: float | None = None,
    idle_s: float | None = None,
    sender: str | None = None,
    restart: bool = False,
) -> Reception:
    """Receives pulses that are sent as VITA 49.2 (docs/wire.md): an iterator over whole pulses.

    Args:
        address: address and port of this machine; port 0 takes a free one (`Reception.address`).
        pulses: ends after so many whole pulses.
        duration_s: ends after so long.
        idle_s: ends when nothing has come for so long, once something has.
        sender: takes datagrams of this sender only.
        restart: whether another run of the sender is followed.

    The wire carries samples and reported navigation; `Pulse.truth` is empty.
    """
    return Reception(address, pulses, duration_s, idle_s, sender, restart)
