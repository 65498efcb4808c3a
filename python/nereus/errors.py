"""Exceptions, with the texts of the command line."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = [
    "ArrayError",
    "InputError",
    "InternalError",
    "NereusError",
    "RunError",
    "ScenarioError",
    "StreamClosed",
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


class RunError(NereusError, RuntimeError):
    """A run failed after it had started (exit code 1 of the program)."""


class StreamClosed(NereusError):
    """A stream is used after it was closed."""


class InternalError(NereusError):
    """A fault of nereus itself."""
