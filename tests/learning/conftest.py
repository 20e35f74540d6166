"""Environments that tests of learning share: made once, since a world takes time to draw."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import graphnav

FAST: dict[str, Any] = {"act": "guard", "time_limit_s": 1.0}
"""Without detector and guard, for ten steps."""


@pytest.fixture(scope="session")
def _fast() -> Iterator[Any]:
    env = graphnav.make_env("corridor_ccw", **FAST, render_mode="rgb_array")
    yield env
    env.close()


@pytest.fixture
def fast(_fast: Any) -> Any:
    """Return an environment at the start of the episode of seed 3."""
    _fast.reset(seed=3)
    return _fast
