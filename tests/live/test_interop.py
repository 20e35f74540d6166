"""Live runs among other programs: driven, overridden and stopped from outside, watched on the group they work on."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

from graphnav import GuardState, Odometry, State, Status, Stop, Twist
from graphnav.core.cli import main
from graphnav.core.codec import decode
from graphnav.core.tap import Tap

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

GUARDED = """
run: {record: small}
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t, max_age_s: 10}
  operator.twist: {channel: TELEOP, type: graphnav_lcm.twist_t}
  operator.stop: {channel: STOP, type: graphnav_lcm.stop_t}
stages:
  see: {use: probe.brightness, in: {image: camera.image}}
  guard:
    use: control.guard
    every_ms: 20
    with: {max_age_s: 10, min_contrast_gray: 0}
    in: {command: see.twist, image: camera.image, override: operator.twist, stop: operator.stop}
outputs: {guard.twist: {channel: BASE, motor: true}}
"""
LATE = """
run: {record: small}
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  see: {use: probe.brightness, with: {dawdle_s: 0.2}, in: {image: camera.image}, deadline_ms: 50}
outputs: {see.twist: {channel: SPEED, motor: false}}
"""
BUSY_S = 0.5
"""How late a busy machine may handle the last command; without its timeout the robot would drive on for 2.5 s."""


def test_pub_drives_the_robot_which_stands_again_by_its_own_timeout(live: Begin, outside: Program, group: str) -> None:
    program = outside("CAMERA")
    run = live("extends: robot_live\nstages: {robot: {with: {state_hz: 100}}}")
    program.wait_for(lambda: bool(program.of("CAMERA")))
    assert main(["pub", "BASE_CMD", "Twist", "v_mps: 0.2", "--rate", "20", "--for", "1", "--url", group]) == 0
    published_s = time.monotonic()
    program.wait_for(lambda: time.monotonic() > published_s + 2.5)
    summary, log = run.stop()
    assert summary.outcome == "stopped"
    states = [(utime, m) for utime, _, m in log.messages("robot.state") if isinstance(m, State)]
    heard = [event.utime for event in log.events() if event.channel == "base.twist"]
    assert len(heard) >= 2
    (_, first), (_, last) = states[0], states[-1]
    expected_m = 0.2 * ((heard[-1] - heard[0]) * 1e-6 + 0.5 + BUSY_S)
    assert 0.05 < math.hypot(last.x_m - first.x_m, last.y_m - first.y_m) < expected_m + 0.02
    stood_s = (max(utime for utime, m in states if m.v_mps > 0) - heard[-1]) * 1e-6
    assert stood_s <= 0.5 + 0.2 / 2.0 + BUSY_S, "the command's timeout, then v/a"


PATIENT = """
extends: navigate_robot
inputs: {camera.image: {max_age_s: 10}}
stages: {guard: {with: {max_age_s: 10}}}
"""
"""navigate_robot, of which no stage is too late on a busy machine."""


def test_navigate_drives_a_robot_of_which_it_has_only_the_camera(live: Begin, outside: Program) -> None:
    program = outside("BASE_CMD", "ODOMETRY")
    navigation = live(PATIENT, "navigation")
    robot = live("extends: robot_live", "robot")
    program.wait_for(lambda: any(v_mps > 0.05 for _, v_mps in program.speeds("BASE_CMD")))
    program.wait_for(lambda: any(decode(Odometry, data)[2].v_mps > 0.02 for data in program.of("ODOMETRY")))
    assert navigation.stop()[0].outcome == "stopped"
    summary, log = robot.stop()
    assert summary.outcome == "stopped"
    assert any(m.v_mps > 0.0 for _, _, m in log.messages("base.twist") if isinstance(m, Twist))


def test_an_operator_overrides_the_graph_stops_it_and_arms_it_again(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    run = live(GUARDED)

    def until(v_mps: float, override: float | None = None) -> None:
        """Show pictures, and override where asked to, until a command leaves."""
        count = len(program.of("BASE"))

        def has_left() -> bool:
            program.show("CAMERA", 7)
            if override is not None:
                program.say("TELEOP", Twist(v_mps=override, omega_radps=0.5))
            time.sleep(0.02)
            return v_mps in {v for _, v in program.speeds("BASE")[count:]}

        program.wait_for(has_left)

    until(7.0)
    until(-3.0, override=-3.0)
    until(7.0)
    program.say("STOP", Stop(engaged=True, reason="by hand"))
    until(0.0)
    stopped = len(program.of("BASE"))
    for _ in range(20):
        program.show("CAMERA", 7)
        program.say("TELEOP", Twist(v_mps=-3.0, omega_radps=0.5))
        time.sleep(0.02)
    program.wait_for(lambda: len(program.of("BASE")) > stopped + 3)
    assert {v for _, v in program.speeds("BASE")[stopped:]} == {0.0}, "it latches, and no override ends it"
    program.say("STOP", Stop(engaged=False, reason="by hand"))
    until(7.0)
    _, log = run.stop()
    states = [m for _, _, m in log.messages("guard.state") if isinstance(m, GuardState)]
    commands = [m for _, _, m in log.messages("guard.twist") if isinstance(m, Twist)]
    assert len(states) == len(commands)
    assert {m.v_mps for m, state in zip(commands, states, strict=True) if state.overridden} == {-3.0}
    assert {m.v_mps for m, state in zip(commands, states, strict=True) if state.stopped} == {0.0}
    told = [(state.overridden, state.stopped) for state in states]
    assert set(told) == {(False, False), (True, False), (False, True)}
    assert told[-1] == (False, False)
    stops = [is_stopped for _, is_stopped in told]
    assert sum(after and not before for before, after in pairwise(stops)) == 1, "it was stopped once, until armed"


def test_the_tap_repeats_nothing_that_comes_in_or_leaves_on_the_same_group(
    live: Begin, outside: Program, group: str
) -> None:
    program = outside("CAMERA", "camera.image", "TELEOP", "operator.twist", "BASE", "guard.twist", "see.twist")
    run = live(GUARDED, tap=Tap("thin", "run-1", group))
    sent = [program.show("CAMERA", 7) for _ in range(2)]
    while len(program.of("see.twist")) < 5 or len(program.of("BASE")) < 20:
        sent.append(program.show("CAMERA", 7))
        program.say("TELEOP", Twist(v_mps=-3.0, omega_radps=0.5))
        time.sleep(0.02)
    run.stop()
    heard = Counter(int.from_bytes(data[8:16], "big", signed=True) for data in program.of("CAMERA"))
    assert set(heard) <= set(sent)
    assert set(heard.values()) == {1}
    teleop = program.of("TELEOP")
    assert len(teleop) == len(set(teleop))
    left = [decode(Twist, data) for data in program.of("BASE")]
    moving = [seq for _, seq, twist in left if twist.v_mps]
    assert len(moving) == len(set(moving))
    assert not program.of("camera.image")
    assert not program.of("operator.twist")
    assert not program.of("guard.twist")


def test_lateness_is_told_and_is_in_the_status_and_the_summary(live: Begin, outside: Program, group: str) -> None:
    program = outside("SPEED", "graphnav.status")
    run = live(LATE, tap=Tap("thin", "run-1", group))

    def statuses() -> list[Status]:
        return [decode(Status, data)[2] for data in program.of("graphnav.status")]

    def is_told() -> bool:
        program.show("CAMERA", 7)
        time.sleep(0.02)
        return any(status.stages[0]["missed"] and status.edges for status in statuses()) and len(run.notices) >= 2

    program.wait_for(is_told)
    summary, log = run.stop()
    (stage,), (edge,) = statuses()[-1].stages, statuses()[-1].edges
    assert stage["name"] == "see"
    assert stage["deadline_ms"] == 50
    assert stage["p50_ms"] >= 200
    assert (edge["name"], edge["channel"]) == ("see.image", "camera.image")
    assert statuses()[-1].processes == ()
    assert stage["overtaken"] == edge["overtaken"] > 0
    assert summary.stages["see"].missed is not None
    assert summary.stages["see"].missed >= stage["missed"] > 0
    assert summary.stages["see"].dropped >= edge["overtaken"]
    assert any(line.startswith("late: see missed its deadline of 50 ms") for line in run.notices)
    assert any("overtaken on see.image" in line for line in run.notices)
    recorded = [m for _, _, m in log.messages("graphnav.status") if isinstance(m, Status)]
    assert recorded[-1].stages[0]["missed"] > 0
