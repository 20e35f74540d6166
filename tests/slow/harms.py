"""Find when a robot brakes and drives on after something that it needs was harmed, by the log of its world."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from graphnav import Recording, State
from graphnav.core.run_folder import RunFolder

STANDS_MPS = 0.01
WAIT_S = 10.0
"""Longer than it takes to drive on."""


class Harm(NamedTuple):
    """Effect of a process that was killed or suspended: times in seconds, infinite where something never came."""

    stage: str
    brakes_s: float
    on_s: float
    """Until the robot drives on."""


def states_of(robot: Path) -> list[tuple[float, State]]:
    """Return the states of the robot in a run's folder, by their time, s."""
    with Recording(robot / RunFolder.LOG) as log:
        return [(utime * 1e-6, state) for utime, _, state in log.messages("robot.state") if isinstance(state, State)]


def harm_of(stage: str, begin_s: float, states: Sequence[tuple[float, State]], lasting_s: float) -> Harm:
    """Find when the robot began to brake until it stood, and when it drove on."""
    after = [(s - begin_s, state) for s, state in states if 0.0 <= s - begin_s <= WAIT_S + lasting_s]
    stands_s = next((s for s, state in after if abs(state.v_mps) < STANDS_MPS), float("inf"))
    driving = [s for s, state in after if s <= stands_s and state.v_mps >= _speed_before(after) - STANDS_MPS]
    brakes_s = max(driving, default=0.0) if stands_s < float("inf") else float("inf")
    on_s = next((s for s, state in after if s > stands_s and state.v_mps > 0.1), float("inf"))
    return Harm(stage, brakes_s, on_s)


def _speed_before(after: Sequence[tuple[float, State]]) -> float:
    return after[0][1].v_mps if after else 0.0
