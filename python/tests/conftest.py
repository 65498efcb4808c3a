"""A small scene for every test."""

import pytest
from scenes import small

import nereus


@pytest.fixture
def scene() -> nereus.Scenario:
    return nereus.Scenario(small())
