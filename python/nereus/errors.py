"""Exceptions, and what several modules refuse by the same words."""

from __future__ import annotations

import difflib
import importlib
import os
from collections.abc import Iterable
from typing import Any

__all__ = [
    "ArrayError",
    "InputError",
    "InternalError",
    "MissingFileError",
    "NereusError",
    "OutputExistsError",
    "RecordingError",
    "RunError",
    "ScenarioError",
    "StreamClosed",
    "SweepError",
    "WorkerError",
]


class NereusError(Exception):
    """What all exceptions of nereus are."""


class InputError(NereusError, ValueError):
    """An argument or a file is wrong (exit code 2 of the program)."""


class ScenarioError(InputError):
    """A scenario is wrong, or cannot be run. `faults` lists every fault; the text has them with their places."""

    def __init__(self, text: str, faults: Iterable[str] = ()) -> None:
        super().__init__(text)
        self.faults = list(faults)

    def __reduce__(self) -> tuple[type[ScenarioError], tuple[str, list[str]]]:
        return type(self), (str(self), self.faults)


class ArrayError(InputError):
    """An array cannot be part of a scenario: its type, its shape or its values."""


# The builtin kind first: `__new__` is that of the kind with more of a layout, as unpickling takes it.
class MissingFileError(FileNotFoundError, InputError):
    """A scenario, a recording or the folder of an output does not exist."""


class OutputExistsError(FileExistsError, InputError):
    """An output exists already: `force=True` replaces it, if it is a recording of nereus."""


class RecordingError(InputError):
    """What was given is no recording of nereus, or a damaged one; the text says what, where and what helps."""


class RunError(NereusError, RuntimeError):
    """A run failed after it had started (exit code 1 of the program)."""


class SweepError(RunError):
    """A case of a sweep failed; the text names it, `__cause__` is its exception."""


class WorkerError(RunError):
    """The workers cannot do it: they lack the package or have another version, none answers, or a job ends them."""


class StreamClosed(NereusError):
    """A stream is used after it was closed."""


class InternalError(NereusError):
    """A fault of nereus itself."""


def existing(path: str | os.PathLike[str], what: str) -> str:
    """The path of what has to exist: a file or a folder. A pipe waits for who writes into it, and a device may never end."""
    path = os.fsdecode(path)
    if not os.path.exists(path):
        beside = "" if os.path.isabs(path) else f", the working directory is {os.getcwd()}"
        raise MissingFileError(f"{path}: no such {what}{beside}")
    if not (os.path.isfile(path) or os.path.isdir(path)):
        raise InputError(f"{path}: is a pipe or a device; allowed: a {what}")
    return path


def text(what: str, value: str) -> str:
    """A text that can be written: Python's may hold halves of characters, as of names of files in another encoding."""
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise InputError(f"{what}: {value[:60]!r} has half a character at {error.start}; allowed: whole characters of Unicode") from None
    return value


def unknown(what: str, name: str, allowed: Iterable[str]) -> InputError:
    """The exception for a name that is none of the allowed ones."""
    allowed = sorted(allowed)
    # Of names that are alike, the one that begins alike: `windd` means `wind_mps` rather than `kind`.
    close = difflib.get_close_matches(name, allowed, 5)
    meant = max(close, key=lambda other: len(os.path.commonprefix([name, other])), default=None)
    hint = f"; did you mean {meant!r}?" if meant else ""
    return InputError(f"{what} {name!r} is unknown{hint}; allowed: {', '.join(allowed)}")


def needs(what: str, extra: str, *packages: str) -> Any:
    """Imports optional packages and returns the first; where one is missing, says what installs it."""
    for package in reversed(packages):
        try:
            module = importlib.import_module(package)
        except ImportError as error:
            text = f"{what} needs {package.partition('.')[0]} ({error}); remedy: pip install './python[{extra}]' at the root of the repository"
            raise ImportError(text, name=package) from error
    return module
