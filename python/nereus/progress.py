"""Progress of recordings."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import contextmanager
from typing import Iterator, Union

#: Called with pulses that are behind us, all pulses, late and dropped ones.
Call = Callable[[int, int, int, int], object]
Wanted = Union[bool, Call]


@contextmanager
def shown(wanted: Wanted) -> Iterator[Call | None]:
    """What shows progress: a bar of tqdm where that is installed, else a line every two seconds."""
    if not wanted:
        yield None
    elif callable(wanted):
        yield wanted
    else:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            yield _lines()
            return
        bar = tqdm(unit=" pulses")

        def move(passed: int, total: int, late: int, dropped: int) -> None:
            bar.total = total
            if late or dropped:
                bar.set_postfix(late=late, dropped=dropped, refresh=False)
            bar.update(passed - bar.n)

        try:
            yield move
        finally:
            bar.close()


def _lines() -> Call:
    last = time.monotonic()

    def line(passed: int, total: int, late: int, dropped: int) -> None:
        nonlocal last
        if time.monotonic() - last >= 2.0:
            last = time.monotonic()
            trouble = f", {late} late, {dropped} dropped" if late or dropped else ""
            print(f"{passed} of {total} pulses{trouble}", file=sys.stderr)

    return line
