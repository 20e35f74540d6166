"""It drives: one or two worlds of every claim that tests/slow counts over twenty."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from graphnav import Recording, State
from graphnav.core.runner.recording.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]
SMALL = "run.record=small"


@pytest.mark.long
@pytest.mark.parametrize(("graph", "seed", "plane"), [("corridor_ccw", 1000, "ica"), ("corridor_cw", 1001, "affine")])
def test_the_corridors_are_driven_to_the_goal(drive: Drive, graph: str, seed: int, plane: str) -> None:
    summary, _ = drive(graph, seed, f"plane=plane.{plane}", SMALL)
    assert summary.outcome == "goal", summary.failure
    assert summary.scores["drive"]["success"] == 1.0


@pytest.mark.long
@pytest.mark.parametrize(("plane", "seed"), [("ica", 1000), ("truth", 1001)])
def test_pillars_are_crossed_to_the_goal(drive: Drive, plane: str, seed: int) -> None:
    assert drive("pillars", seed, f"plane=plane.{plane}", SMALL)[0].outcome == "goal"


def test_the_block_is_not_touched(drive: Drive) -> None:
    assert drive("approach", 1000, SMALL)[0].outcome in {"timeout", "goal"}


@pytest.mark.parametrize(("graph", "seed"), [("corridor_cw", 1001), ("pillars", 1000)])
def test_driving_straight_ahead_fails(drive: Drive, graph: str, seed: int) -> None:
    assert drive(graph, seed, "steer=steer.forward", SMALL)[0].outcome in {"contact", "timeout"}


@pytest.mark.long
def test_a_camera_of_640x480_drives_the_same_way(drive: Drive) -> None:
    large = [
        "robot.size=[640,480]", "flow=flow.dis", "flow.preset=fast", "planar.model=models/downward_640x480.lcmlog"
    ]  # fmt: skip
    ends, sights = [], []
    for sets in ([], large):
        summary, log = drive("corridor_ccw", 7, "run.until_s=5", SMALL, *sets)
        assert summary.outcome == "timeout", summary.failure
        state = log.message("robot.state", -1)[2]
        assert isinstance(state, State)
        ends.append((state.x_m, state.y_m))
        sights.append(summary.scores["sight"]["balanced_accuracy_ratio"])
    assert np.linalg.norm(np.diff(ends, axis=0)) < 0.3
    assert sights[1] > sights[0] - 0.05
