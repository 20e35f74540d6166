"""When a robot that does not get on is noticed, and what is done about it, on maps that are drawn by hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from graphnav_steer.headings import headed
from graphnav_steer.recovery import Recovery

from graphnav import LocalMap, RecoveryState, Steering

DrawMap = Callable[..., LocalMap]
WANTED = headed(0.7)
TURN_RAD = 2 * math.pi
STEP_RAD = 0.12
"""A robot that turns at 1.2 rad/s, ten times a second."""


class Robot:
    """A robot on a map that wants to drive ahead, and turns where it is told to in the test."""

    def __init__(self, draw: Callable[[tuple[float, float, float]], LocalMap], **parameters: Any) -> None:
        self.stage = Recovery(**({"turns": 2.0, "step_turns": 1.0, "doubt": 8.0, "back_m": 0.6} | parameters))
        self.stage.reset(seed=0)
        self._draw = draw
        self.x_m = self.y_m = self.yaw_rad = 0.0
        self.steering: Steering = WANTED
        self.states: list[RecoveryState] = []

    def step(self, forward_m: float = 0.0, turn_rad: float = 0.0) -> RecoveryState:
        """Drive and turn, and return the state there."""
        self.x_m += forward_m * math.cos(self.yaw_rad)
        self.y_m += forward_m * math.sin(self.yaw_rad)
        self.yaw_rad = math.remainder(self.yaw_rad + turn_rad, TURN_RAD)
        self.steering, state = self.stage.step(WANTED, self._draw((self.x_m, self.y_m, self.yaw_rad)))
        self.states.append(state)
        return state

    def turn(self, turns: float, step_rad: float = STEP_RAD) -> RecoveryState:
        """Turn on the spot by so many full turns, and return the last state."""
        return [self.step(turn_rad=step_rad) for _ in range(round(turns * TURN_RAD / abs(step_rad)))][-1]

    def steps(self) -> list[str]:
        """Return what was done, each once, in order."""
        doing = [state.doing for state in self.states]
        return [one for k, one in enumerate(doing) if k == 0 or one != doing[k - 1]]


@pytest.fixture
def make_robot(draw_map: DrawMap) -> Callable[..., Robot]:
    """Return what makes a robot on free floor, or on the map of functions that say where what is."""

    def make(obstacle: Any = None, unknown: Any = None, **parameters: Any) -> Robot:
        where = {name: given for name, given in (("obstacle", obstacle), ("unknown", unknown)) if given is not None}
        return Robot(lambda pose: draw_map(pose=pose, **where), **parameters)

    return make


def ring(x: Any, y: Any) -> Any:
    """Say where an obstacle is that shuts the robot in, with hardly room behind it."""
    return (np.hypot(x, y) > 0.3) & (np.hypot(x, y) < 0.5)


def drive(robot: Robot, motions: Iterable[tuple[float, float]]) -> None:
    for motion in motions:
        robot.step(*motion)
        assert robot.steering is WANTED, "the steering is passed on as it is"


MakeRobot = Callable[..., Robot]


def test_a_robot_that_gets_on_is_steered_as_before(make_robot: MakeRobot) -> None:
    robot = make_robot()
    for side in (1, -1, 1):
        drive(robot, [(0.0, side * STEP_RAD)] * 50)
        drive(robot, [(0.03, 0.0)] * 20)
    assert robot.steps() == [""]
    assert robot.states[-1].recoveries == 0
    assert robot.stage.summary() == {"recoveries": 0.0}


@pytest.mark.parametrize("to_and_fro", [False, True])
def test_turning_on_one_place_is_noticed(make_robot: MakeRobot, to_and_fro: bool) -> None:
    robot = make_robot()
    signs = [1 if not to_and_fro or k // 8 % 2 else -1 for k in range(200)]
    creep_m = [0.01 * (-1) ** (k // 8) for k in range(200)]
    drive(robot, zip(creep_m, (sign * STEP_RAD for sign in signs), strict=True))
    begun = next(k for k, state in enumerate(robot.states) if state.doing == "look_again")
    assert begun * STEP_RAD == pytest.approx(2 * TURN_RAD, rel=0.1)
    assert robot.states[begun].turned_rad == pytest.approx(2 * TURN_RAD, rel=0.02)
    assert robot.states[begun].recoveries == 1
    assert robot.states[begun].doubt == 8.0
    assert robot.stage.summary() == {"recoveries": 1.0}


def test_a_robot_that_stands_is_not_noticed_though_its_odometry_is_noisy(make_robot: MakeRobot) -> None:
    robot = make_robot()
    drive(robot, ((0.001 * (-1) ** k, 0.03 * (-1) ** k) for k in range(2000)))
    assert robot.steps() == [""]


def test_without_turns_the_robot_never_recovers(make_robot: MakeRobot) -> None:
    robot = make_robot(turns=0.0)
    robot.turn(10)
    assert robot.steps() == [""]


def test_the_recovery_ends_when_the_robot_gets_on(make_robot: MakeRobot) -> None:
    robot = make_robot()
    assert robot.turn(2.2).doing == "look_again"
    drive(robot, [(0.03, 0.0)] * 15)
    assert robot.states[-1].doing == "look_again", "0.45 m away it is on the same place"
    drive(robot, [(0.03, 0.0)] * 3)
    assert robot.states[-1].doing == ""
    assert robot.states[-1].turned_rad == 0.0


def test_the_steps_follow_each_other_while_the_robot_turns(make_robot: MakeRobot) -> None:
    robot = make_robot(ring)
    assert robot.turn(2.1).doing == "look_again"
    assert robot.turn(1.0).doing == "other_way"
    assert robot.turn(1.0).doing == "back_out"
    assert robot.turn(1.0).doing == ""
    assert robot.steering is WANTED, "there is no room to drive back"
    assert robot.states[-1].turned_rad < 1.0, "it begins again"


def test_it_backs_out_straight_over_floor_that_is_free(make_robot: MakeRobot) -> None:
    robot = make_robot()
    while robot.states[-1:] == [] or robot.states[-1].doing != "back_out":
        robot.step(turn_rad=STEP_RAD)
    driven_m = 0.0
    while robot.steering.theta_rad == math.pi:
        robot.step(forward_m=-0.03)
        driven_m += 0.03
        assert driven_m < 1.0
    assert driven_m == pytest.approx(0.6, abs=0.031)
    assert robot.states[-1].doing == ""
    assert robot.steering is WANTED


@pytest.mark.parametrize("is_unknown", [False, True])
def test_it_drives_back_only_where_nothing_is_in_the_way_and_as_far(make_robot: MakeRobot, is_unknown: bool) -> None:
    where = {"unknown" if is_unknown else "obstacle": lambda x, y: np.hypot(x, y) > 0.55}
    robot = make_robot(**where)
    robot.turn(4.1)
    while robot.steering is WANTED:
        assert robot.step(turn_rad=STEP_RAD).doing == "back_out", "it drives back before the step ends"
    assert robot.states[-1].turned_rad > 4.5 * TURN_RAD - STEP_RAD, "0.6 m are not free: it waits for half of the step"
    while robot.steering is not WANTED:
        robot.step(forward_m=-0.03)
    assert 0.2 < 0.55 - math.hypot(robot.x_m, robot.y_m) < 0.4


def test_without_back_m_it_does_not_drive_back(make_robot: MakeRobot) -> None:
    robot = make_robot(back_m=0.0)
    drive(robot, [(0.0, STEP_RAD)] * round(6 * TURN_RAD / STEP_RAD))
    assert "back_out" in robot.steps()


def test_what_did_not_help_is_followed_by_more_doubt_on_the_same_place_only(make_robot: MakeRobot) -> None:
    robot = make_robot(ring)
    robot.turn(5 * 4 + 0.5)
    doubts = sorted({(state.recoveries, state.doubt) for state in robot.states if state.recoveries})
    assert doubts[:3] == [(1, 8.0), (2, 16.0), (3, 32.0)]
    drive(robot, [(0.1, 0.0)] * 30)
    assert robot.turn(2.2).doubt == 8.0
