"""A small scene for every test."""

import signal

import pytest
from scenes import small

import nereus

# Tests interrupt runs, also where a shell in the background has interrupts ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def scene() -> nereus.Scenario:
    return nereus.Scenario(small())
