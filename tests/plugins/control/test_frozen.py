"""A picture that does not move as the robot does, and odometry that contradicts it: the guard stops, and holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from graphnav_control.guard import Guard, GuardOutputs

from graphnav import Age, Flow, Latest, Motion, Mount, OdometryCheck, Stamp, Stop, Twist

GUARD_US = 50_000
AHEAD = Twist(v_mps=0.3, omega_radps=0.0)
MOUNT = Mount(1.0, 75.0, 70.0, 0.0)
ROWS, COLS, STEP_PX = 30, 40, 4
UNWIRED: Latest[Any] = Latest(is_connected=False)
WRONG = OdometryCheck(fault="reversed", value=-1.0, limit=0.0, agrees=False)
RIGHT = OdometryCheck(fault="", value=0.0, limit=0.0, agrees=True)
SILENT = OdometryCheck(fault="", value=0.0, limit=0.0, agrees=False)


def moved(v_mps: float, omega_radps: float, interval_us: int) -> Motion:
    s = interval_us * 1e-6
    return Motion(forward_m=v_mps * s, left_m=0.0, turn_rad=omega_radps * s, interval_us=interval_us)


def flow_of(motion: Motion, noise_px: float = 0.0, seed: int = 0) -> Flow:
    """Return the flow of a floor over which the robot moves."""
    valid = np.ones((ROWS, COLS), np.uint8)
    blank = Flow(uv_px=np.zeros((ROWS, COLS, 2), np.float32), valid=valid, interval_us=1, step_px=STEP_PX)
    uv_px = MOUNT.floor_moved_px(blank, motion).reshape(ROWS, COLS, 2)
    uv_px = uv_px + noise_px * np.random.default_rng(seed).standard_normal(uv_px.shape)
    return Flow(uv_px=uv_px.astype(np.float32), valid=valid, interval_us=motion.interval_us, step_px=STEP_PX)


class Robot:
    """A robot whose guard fires every 50 ms; it does at once what it is told, and its picture may be frozen."""

    def __init__(self, hz: float = 10.0, *, has_odometry: bool = False, **parameters: Any) -> None:
        self.guard = Guard(**parameters)
        self.guard.reset(seed=0)
        self.period_us = round(1e6 / hz)
        self.utime = self.frames = 0
        self.way_m = 0.0
        self.is_frozen = False
        self.coast_us = 0
        """How long odometry goes on to report the last speed after a stop."""
        self.measured: Twist | None = None
        """The motion that odometry reports, if not the true one."""
        self.check: OdometryCheck | None = None
        self.noise_px = 0.01
        self.flow: Flow | None = None
        self._has_odometry = has_odometry
        self._flow: Latest[Any] = Latest()
        self._motion: Latest[Any] = Latest()
        self._stop: Latest[Any] = Latest(is_connected=False)
        self._last = self._driven = Twist(v_mps=0.0, omega_radps=0.0)
        self._driven_us = 0

    def press(self, *, engaged: bool) -> None:
        self._stop = Latest(Stop(engaged=engaged), 0.01)

    def fire(
        self, command: Twist | None = AHEAD, override: Twist | None = None, shown: Twist | None = None
    ) -> GuardOutputs:
        """Go on to the next firing; ``shown``: how the picture moves, if not as the robot."""
        self.utime += GUARD_US
        if self.utime // self.period_us > self.frames:
            self.frames = self.utime // self.period_us
            self._picture(shown or self._last)
        outputs = self.guard.step(
            command=command,
            plane=UNWIRED,
            image=UNWIRED,
            flow=Latest(self._flow.value, 0.01),
            deviation=UNWIRED,
            motion=Latest(self._motion.value, 0.01) if self._has_odometry else UNWIRED,
            odometry=UNWIRED if self.check is None else Latest(self.check, 0.01),
            override=UNWIRED if override is None else Latest(override, 0.01),
            stop=self._stop,
            utime=Stamp(self.utime),
            command_age_s=Age(0.01),
        )
        self._last = outputs.twist
        self.way_m += abs(self._last.v_mps) * GUARD_US * 1e-6
        return outputs

    def run(self, seconds: float, command: Twist | None = AHEAD, **inputs: Any) -> list[GuardOutputs]:
        return [self.fire(command, **inputs) for _ in range(round(seconds * 1e6 / GUARD_US))]

    def _picture(self, speed: Twist) -> None:
        motion = moved(speed.v_mps, speed.omega_radps, self.period_us)
        if self._last.v_mps or self._last.omega_radps or self.utime - self._driven_us > self.coast_us:
            self._driven, self._driven_us = self._last, self.utime
        measured = self.measured or self._driven
        self._motion = Latest(moved(measured.v_mps, measured.omega_radps, self.period_us))
        still = moved(0.0, 0.0, self.period_us)
        flow = self.flow or flow_of(still if self.is_frozen else motion, self.noise_px, self.frames)
        self._flow = Latest(replace(flow))


def found(outputs: Sequence[GuardOutputs]) -> list[tuple[str, ...]]:
    return [one.state.causes for one in outputs]


@pytest.fixture(params=[False, True], ids=["by commands", "by odometry"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return Robot(has_odometry=request.param)


def test_a_picture_that_stops_moving_stops_the_robot_within_half_a_second(robot: Robot) -> None:
    assert not any(found(robot.run(3.0)))
    robot.is_frozen, robot.way_m = True, 0.0
    outputs = robot.run(0.6)
    stops = [one for one in outputs if not one.state.may_move]
    assert 0 < robot.way_m <= 0.3 * 0.5 + 1e-9
    state = stops[-1].state
    assert (state.causes, state.ports, list(state.limits)) == (("frozen",), ("flow",), [0.1])
    assert 0.0 < state.values[0] < 0.1
    assert (stops[0].twist.v_mps, stops[0].twist.omega_radps) == (0.0, 0.0)


@pytest.mark.parametrize(
    "told",
    [
        ((0.4, AHEAD), (0.3, Twist(v_mps=0.0, omega_radps=0.8))),
        (
            (0.4, AHEAD),
            (0.3, Twist(v_mps=0.0, omega_radps=0.8)),
            (0.4, AHEAD),
            (0.3, Twist(v_mps=0.0, omega_radps=-0.8)),
        ),
        ((0.3, AHEAD), (0.2, Twist(v_mps=0.0, omega_radps=0.0))),
    ],
    ids=["turns to one side", "turns to both sides", "stops"],
)
@pytest.mark.parametrize("hz", [10.0, 30.0])
def test_drives_that_are_shorter_than_a_base_may_take_to_begin_are_judged(
    hz: float, told: Sequence[tuple[float, Twist]]
) -> None:
    robot = Robot(hz)
    for _ in range(8):
        for seconds, command in told:
            assert not any(found(robot.run(seconds, command)))
    robot.is_frozen, robot.way_m = True, 0.0
    for _ in range(20):
        for seconds, command in told:
            outputs = robot.run(seconds, command)
    assert outputs[-1].state.stopped
    assert robot.way_m <= 0.4


def test_a_base_that_coasts_on_a_frozen_picture_does_not_block_the_retry() -> None:
    robot = Robot(has_odometry=True)
    robot.run(2.0)
    robot.is_frozen, robot.coast_us = True, 700_000
    robot.run(0.6)
    robot.way_m = 0.0
    assert robot.run(10.0)[-1].state.stopped
    assert 0.03 < robot.way_m <= 0.1
    robot.way_m = 0.0
    robot.press(engaged=False)
    robot.run(5.0)
    assert 0.03 < robot.way_m <= 0.1


def test_a_picture_that_freezes_while_an_operator_drives_is_named_and_holds_the_robot_after_it() -> None:
    robot = Robot()
    robot.run(2.0)
    robot.run(1.0, override=AHEAD)
    robot.is_frozen = True
    driven = robot.run(2.0, override=AHEAD)
    assert {"frozen"} <= set(driven[-1].state.causes)
    assert driven[-1].twist.v_mps == AHEAD.v_mps
    assert robot.fire().twist.v_mps == 0.0


def test_odometry_that_hangs_as_the_picture_does_is_not_believed() -> None:
    robot = Robot(has_odometry=True)
    robot.run(2.0)
    robot.is_frozen, robot.way_m = True, 0.0
    robot.measured = Twist(v_mps=0.0, omega_radps=0.0)
    assert robot.run(20.0)[-1].state.stopped
    assert robot.way_m <= 0.3 * 2.3 + 0.1


def test_odometry_that_stands_is_believed_where_commands_are_smaller_than_a_base_may_ignore() -> None:
    robot = Robot(has_odometry=True)
    robot.is_frozen, robot.measured = True, Twist(v_mps=0.0, omega_radps=0.0)
    assert not any(found(robot.run(6.0, Twist(v_mps=0.04, omega_radps=0.05))))


@pytest.mark.parametrize("retry_m", [0.0, 0.1])
def test_a_fast_operator_frees_the_robot_too(retry_m: float) -> None:
    robot = Robot(retry_m=retry_m)
    robot.run(2.0)
    robot.is_frozen = True
    robot.run(4.0)
    robot.is_frozen = False
    fast = Twist(v_mps=1.0, omega_radps=0.0)
    robot.run(1.0, override=fast)
    assert robot.run(0.1)[-1].state.causes == ()


def test_it_retries_once_by_a_tenth_of_a_metre_and_then_waits_for_an_operator(robot: Robot) -> None:
    robot.run(2.0)
    robot.is_frozen = True
    robot.run(0.6)
    robot.way_m = 0.0
    outputs = robot.run(20.0)
    assert 0.03 < robot.way_m <= 0.1
    assert outputs[-1].state.stopped
    assert any(one.state.may_move and "frozen" in one.state.causes for one in outputs)
    assert not outputs[-1].state.may_move
    robot.way_m = 0.0
    robot.press(engaged=False)
    assert robot.run(20.0)[-1].state.stopped
    assert 0.03 < robot.way_m <= 0.1


def test_a_heartbeat_of_messages_that_arm_is_one_order(robot: Robot) -> None:
    robot.run(2.0)
    robot.is_frozen, robot.way_m = True, 0.0
    for _ in range(300):
        robot.press(engaged=False)
        robot.fire()
    assert robot.way_m <= 0.3 * 0.5 + 0.1


def test_messages_that_arm_again_and_again_and_a_flickering_picture_drive_it_half_a_metre_at_most(robot: Robot) -> None:
    robot.run(2.0)
    robot.is_frozen = True
    robot.run(0.6)
    robot.way_m = 0.0
    for _ in range(20):
        robot.press(engaged=False)
        robot.run(2.0)
        robot.run(0.1, shown=Twist(v_mps=0.1, omega_radps=0.0))
    assert robot.way_m <= 0.5 + 1e-9
    robot.is_frozen = False
    robot.run(0.5, override=AHEAD)
    assert robot.run(0.1)[-1].state.causes == ()


def test_a_picture_that_moves_again_is_trusted_after_two_flows(robot: Robot) -> None:
    robot.run(2.0)
    robot.is_frozen = True
    robot.run(4.0)
    robot.is_frozen, robot.way_m = False, 0.0
    robot.run(1.0)
    assert robot.way_m == 0.0  # it stands, and the picture does as well
    robot.run(0.1, shown=Twist(v_mps=0.1, omega_radps=0.0))  # what came when the camera did
    outputs = robot.run(2.0)
    assert outputs[-1].state.causes == ()
    assert outputs[-1].twist.v_mps == AHEAD.v_mps


def test_an_operator_may_drive_but_the_latch_holds_until_the_picture_moved(robot: Robot) -> None:
    robot.run(2.0)
    robot.is_frozen = True
    robot.run(4.0)
    driven = robot.run(3.0, override=AHEAD)
    assert all(
        one.twist.v_mps == AHEAD.v_mps and "frozen" in one.state.causes and not one.state.stopped for one in driven
    )
    robot.way_m = 0.0
    assert not robot.run(1.0)[-1].state.may_move
    assert robot.way_m <= 0.1
    robot.is_frozen = False
    robot.run(0.5, override=AHEAD)
    assert robot.run(0.1)[-1].state.causes == ()


@pytest.mark.parametrize(
    ("hz", "command"),
    [
        (10.0, AHEAD),
        (30.0, Twist(v_mps=0.05, omega_radps=0.0)),
        (20.0, Twist(v_mps=0.01, omega_radps=0.0)),
        (10.0, Twist(v_mps=0.0, omega_radps=0.5)),
        (10.0, Twist(v_mps=-0.2, omega_radps=-0.3)),
    ],
)
@pytest.mark.parametrize("noise_px", [0.0, 0.02])
def test_every_motion_is_judged_and_none_stops_that_the_picture_shows(
    hz: float, command: Twist, noise_px: float
) -> None:
    for is_frozen in (False, True):
        robot = Robot(hz)
        robot.is_frozen, robot.noise_px = is_frozen, noise_px
        outputs = robot.run(8.0, command)
        assert any(found(outputs)) is is_frozen


def test_a_robot_that_stands_is_not_frozen(robot: Robot) -> None:
    robot.is_frozen = True
    assert not any(found(robot.run(10.0, Twist(v_mps=0.0, omega_radps=0.0))))


def test_doubled_frames_are_not_frozen(robot: Robot) -> None:
    for k in range(100):
        robot.is_frozen = k // 2 % 2 == 1
        assert robot.fire().state.causes == ()


def test_a_base_gets_half_a_second_to_begin() -> None:
    robot = Robot()
    still = Twist(v_mps=0.0, omega_radps=0.0)
    assert not any(found(robot.run(0.8, shown=still)))
    assert found(robot.run(0.5, shown=still))[-1] == ("frozen",)


def test_motors_that_take_nothing_again_and_again_are_not_a_frozen_picture() -> None:
    robot, still = Robot(), Twist(v_mps=0.0, omega_radps=0.0)
    causes = found(robot.run(3.0))
    for _ in range(8):
        # The run withholds the commands 0.55 s after the motors have taken the last one.
        causes += found(robot.run(0.5, command=None, shown=still)) + found(robot.run(0.6, shown=still))
    assert not any("frozen" in found for found in causes)
    robot.run(0.5, command=None, shown=still)
    robot.is_frozen = True
    assert ("frozen",) in found(robot.run(1.5))


def test_zero_pixels_judge_nothing() -> None:
    robot = Robot(frozen_px=0.0)
    robot.is_frozen = True
    assert not any(found(robot.run(5.0)))


def test_a_flow_without_valid_vectors_is_no_evidence(robot: Robot) -> None:
    nothing = flow_of(moved(0.0, 0.0, 100_000))
    nothing.valid[:] = 0
    robot.flow = nothing
    assert not any(found(robot.run(5.0)))


def test_a_wired_flow_that_is_lost_stops_the_robot() -> None:
    robot = Robot()
    robot.run(1.0)
    outputs = [robot.guard.step(**_inputs(flow=Latest(flow_of(moved(0.3, 0.0, 100_000)), 0.6)))]
    assert found(outputs) == [("stale",)]
    assert outputs[0].state.ports == ("flow",)


def test_wrong_odometry_holds_the_robot_until_it_agrees() -> None:
    robot = Robot()
    robot.check = RIGHT
    assert not any(found(robot.run(2.0)))
    robot.check, robot.way_m = WRONG, 0.0
    outputs = robot.run(1.0)
    assert robot.way_m == 0.0
    assert outputs[0].state.causes == ("reversed",)
    assert outputs[0].state.ports == ("odometry",)
    robot.check = SILENT
    outputs = robot.run(20.0)
    assert 0.03 < robot.way_m <= 0.1
    assert outputs[-1].state.stopped
    robot.check = RIGHT
    assert robot.run(0.2, override=AHEAD)[-1].state.causes == ()
    assert robot.run(0.1)[-1].twist.v_mps == AHEAD.v_mps


def test_odometry_that_never_agreed_is_not_retried_without_an_operator() -> None:
    robot = Robot()
    robot.check = SILENT
    assert not any(found(robot.run(0.4)))
    robot.check, robot.way_m = WRONG, 0.0
    outputs = robot.run(1.0)
    assert outputs[-1].state.stopped
    robot.check = SILENT
    outputs = robot.run(10.0)
    assert robot.way_m == 0.0
    assert all(output.state.stopped for output in outputs)
    robot.press(engaged=False)
    robot.run(3.0)
    assert 0.03 < robot.way_m <= 0.1


def test_odometry_that_seems_wrong_while_the_robot_stands_holds_it_no_longer() -> None:
    robot, stand = Robot(), Twist(v_mps=0.0, omega_radps=0.0)
    robot.check = WRONG
    assert set(found(robot.run(2.0, stand))) == {("reversed",)}
    robot.check = SILENT
    assert not any(found(robot.run(2.0, stand)))


def _inputs(**given: Any) -> dict[str, Any]:
    return dict.fromkeys(("plane", "image", "deviation", "motion", "odometry", "override", "stop"), UNWIRED) | {
        "command": AHEAD,
        "command_age_s": Age(0.01),
        "utime": Stamp(5_000_000),
        **given,
    }
