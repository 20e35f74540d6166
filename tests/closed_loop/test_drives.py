"""It drives: two seeds of every claim that tools/accept.py counts over twenty."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from graphnav import Recording
from graphnav.runner.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]
SMALL = "run.record=small"


@pytest.mark.parametrize("seed", [1000, 1001])
@pytest.mark.parametrize("plane", ["ica", "affine", "truth"])
@pytest.mark.parametrize("graph", ["corridor_ccw", "corridor_cw"])
def test_the_corridors_are_driven_to_the_goal(drive: Drive, graph: str, plane: str, seed: int) -> None:
    summary, _ = drive(graph, seed, f"plane=plane.{plane}", SMALL)
    assert summary.outcome == "goal", summary.failure
    assert summary.scores["drive"]["success"] == 1.0


@pytest.mark.parametrize("seed", [1000, 1001])
@pytest.mark.parametrize("plane", ["ica", "truth"])
def test_pillars_are_crossed_to_the_goal(drive: Drive, plane: str, seed: int) -> None:
    assert drive("pillars", seed, f"plane=plane.{plane}", SMALL)[0].outcome == "goal"


@pytest.mark.parametrize("seed", [1000, 1001])
def test_the_block_is_not_touched(drive: Drive, seed: int) -> None:
    assert drive("approach", seed, SMALL)[0].outcome in {"timeout", "goal"}


@pytest.mark.parametrize("graph", ["corridor_ccw", "corridor_cw", "pillars", "approach"])
def test_driving_straight_ahead_fails(drive: Drive, graph: str) -> None:
    assert drive(graph, 1000, "steer=steer.forward", SMALL)[0].outcome in {"contact", "timeout"}
    assert drive(graph, 1001, "steer=steer.forward", SMALL)[0].outcome in {"contact", "timeout"}
