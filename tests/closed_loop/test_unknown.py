"""A robot that drives at a white wall turns away or stands, and drives on where the floor can be judged."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from graphnav import GuardState, Recording, Twist
from graphnav.arrays import Doubles
from graphnav.core.runner.recording.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]
OFF = ("steer.unjudged=free", "guard.unjudged=ignore")
SMALL = "run.record=small"


def speeds(log: Recording) -> Doubles:
    found = [twist for _, _, twist in log.messages("guard.twist") if isinstance(twist, Twist)]
    return np.array([(twist.v_mps, twist.omega_radps) for twist in found])


@pytest.mark.parametrize("unjudged", ["obstacle", "hold"])
@pytest.mark.parametrize("seed", [0, 1])
def test_before_a_white_wall_the_robot_turns_or_stands(drive: Drive, seed: int, unjudged: str) -> None:
    summary, log = drive("white_wall", seed, "run.until_s=14", f"guard.unjudged={unjudged}", SMALL)
    assert summary.outcome == "timeout"
    with log:
        states = [state for _, _, state in log.messages("guard.state") if isinstance(state, GuardState)]
        held = [not state.may_move for state in states if "unknown" in state.causes]
        assert all(held) if unjudged == "hold" else not any(held)


def test_without_the_policy_it_hits_the_wall(drive: Drive) -> None:
    assert drive("white_wall", 0, SMALL, *OFF)[0].outcome == "contact"


@pytest.mark.parametrize("sets", [("steer.unjudged=free",), ("steer=steer.forward",)])
def test_the_guard_alone_keeps_it_off_the_wall(drive: Drive, sets: tuple[str, ...]) -> None:
    summary, log = drive("white_wall", 0, "run.until_s=12", SMALL, *sets)
    assert summary.outcome == "timeout"
    with log:
        assert speeds(log)[:, 0].min() == 0.0


@pytest.mark.parametrize(("graph", "sets"), [("white_wall", ("robot.map=maps/empty.yaml",)), ("corridor_ccw", ())])
def test_where_all_can_be_judged_every_command_is_the_same(drive: Drive, graph: str, sets: tuple[str, ...]) -> None:
    driven = []
    for policy in ((), OFF):
        _, log = drive(graph, 2, "run.until_s=4", SMALL, *sets, *policy)
        with log:
            driven.append(speeds(log))
    assert driven[0].tobytes() == driven[1].tobytes()
    assert len(driven[0]) > 35
