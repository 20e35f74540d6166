"""Teleoperation of a live drive, through a terminal: it overrides the graph, stops the robot and arms it again."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path

from testbed.processes import drives_forward, hear
from testbed.rig import Rig

from graphnav import GuardState, Recording, State, Stop, Twist
from graphnav.core.codec import decode
from tests.targets import Targets

from .teleop_keys import TeleopKeys

OVERRIDE_MAX_AGE_S, GUARD_PERIOD_S = 0.3, 0.05
SPEED_MPS, TURN_RADPS = 0.3, 0.8
BRAKES_MPS2, BRAKES_RADPS2 = 0.5 / 0.25, 2.0 / 0.25
ON_TIME_S = 0.05
"""Allowance for the scheduler of a busy machine."""


@dataclass
class Overridden:
    """Events in the navigation's log; times in seconds, NaN for those that did not happen."""

    firings: int = 0
    differing: int = 0
    """Commands that left while overridden and were not the newest of the operator."""
    last_heard_s: float = math.nan
    returned_s: float = math.nan
    stop_s: float = math.nan
    zero_s: float = math.nan
    moved_while_stopped: int = 0
    armed_s: float = math.nan
    drives_on_s: float = math.nan


def test_interop_teleop_overrides_the_graph(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Drive, override, release, stop, arm, drive to the end."""
    with Rig(tmp_path, 202, seeds[1 % len(seeds)], ("--set", "robot.state_hz=100")) as rig:
        rig.navigate()
        hear(rig.graph_url, "BASE_CMD", drives_forward)
        time.sleep(2.0)
        with TeleopKeys(rig.graph_url) as keys:
            time.sleep(2.0)
            for key, for_s in (("j", 1.2), ("l", 1.2), ("s", 0.8)):
                keys.hold(key, for_s)
            time.sleep(3.0)
            keys.press("x")
            time.sleep(2.0)
            keys.press("r")
            time.sleep(1.0)
        robot, _ = rig.finish()
    with Recording(tmp_path / "navigation-0" / "run.lcmlog") as log:
        told = _told(log)
    with Recording(tmp_path / "robot" / "run.lcmlog") as log:
        driven = [(utime * 1e-6, m) for utime, _, m in log.messages("robot.state") if isinstance(m, State)]
    during = [m for at_s, m in driven if at_s < told.returned_s]
    slowest_mps = min(m.v_mps for m in during)
    turns_radps = [max(m.omega_radps for m in during), min(m.omega_radps for m in during)]
    moving = [at_s for at_s, m in driven if told.stop_s < at_s < told.armed_s and (m.v_mps or m.omega_radps)]
    stands_s = max(moving, default=told.stop_s) - told.stop_s
    back_s, zero_s = told.returned_s - told.last_heard_s, told.zero_s - told.stop_s
    brakes_s = max(SPEED_MPS / BRAKES_MPS2, 1.2 / BRAKES_RADPS2)
    good = (
        told.firings > 0
        and told.differing == told.moved_while_stopped == 0
        and slowest_mps < -0.9 * SPEED_MPS
        and min(turns_radps[0], -turns_radps[1]) > 0.9 * TURN_RADPS
        and back_s <= OVERRIDE_MAX_AGE_S + GUARD_PERIOD_S + ON_TIME_S
        and zero_s <= GUARD_PERIOD_S + ON_TIME_S
        and stands_s <= GUARD_PERIOD_S + brakes_s + ON_TIME_S
        and told.drives_on_s > told.armed_s
    )
    targets.check(
        f"{told.firings} firings overridden, {told.differing} with another command than the operator's; the robot "
        f"turned at {turns_radps[0]:+.2f} and {turns_radps[1]:+.2f} rad/s, drove back at {slowest_mps:+.2f} m/s; the "
        f"graph drove on {back_s:.3f} s after the operator's last message; x: stop left after {zero_s:.3f} s, the "
        f"robot stood after {stands_s:.3f} s, {told.moved_while_stopped} commands to move until armed "
        f"{told.armed_s - told.stop_s:.2f} s later; drove on {told.drives_on_s - told.armed_s:.3f} s after r; "
        f"the drive ended with {robot['outcome']}",
        good=good,
    )


def _told(log: Recording) -> Overridden:
    """Read, in the order of the log, what the operator said and what the guard made of it."""
    told = Overridden()
    operator = leaving = (0.0, 0.0)
    is_stopped, operator_s = False, math.nan
    for event in log.events():
        at_s = event.utime * 1e-6
        if event.channel == "operator.twist":
            operator, operator_s = _speeds(event.data), at_s
        elif event.channel == "operator.stop":
            is_stopped = decode(Stop, event.data)[2].engaged
            if is_stopped:
                told.stop_s = at_s
            else:
                told.armed_s = at_s
        elif event.channel == "guard.twist":
            leaving = _speeds(event.data)
        elif event.channel == "guard.state":
            state = decode(GuardState, event.data)[2]
            moves = any(leaving)
            if state.overridden:
                told.firings += 1
                told.differing += leaving != operator
                told.last_heard_s, told.returned_s = operator_s, math.nan
            elif math.isnan(told.returned_s) and not state.stopped:
                told.returned_s = at_s
            if is_stopped:
                told.moved_while_stopped += moves or not state.stopped
                if math.isnan(told.zero_s) and not moves:
                    told.zero_s = at_s
            elif moves and math.isnan(told.drives_on_s) and not math.isnan(told.armed_s):
                told.drives_on_s = at_s
    return told


def _speeds(data: bytes) -> tuple[float, float]:
    twist = decode(Twist, data)[2]
    return twist.v_mps, twist.omega_radps
