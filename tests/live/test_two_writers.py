"""Two programs write one input: a standby does no harm and takes over through one stop; else the robot stands."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import graphnav_lcm

from graphnav import GuardState, Stop, Twist
from graphnav.core.codec import codec_of, encode

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

GUARDED = """
run: {record: small}
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t, max_age_s: 1}
  operator.stop: {channel: STOP, type: graphnav_lcm.stop_t}
stages:
  see: {use: probe.brightness, in: {image: camera.image}}
  guard:
    use: control.guard
    every_ms: 20
    with: {max_age_s: 1, min_contrast_gray: 0}
    in: {command: see.twist, image: camera.image, stop: operator.stop}
outputs: {guard.twist: {channel: BASE, motor: true}}
"""
IMAGE = codec_of(graphnav_lcm.image_t)
ACCEPTED_S = 1.1


class Camera:
    """Shows pictures of one gray level, as a driver in C that zeroes its struct if it does not number them."""

    def __init__(self, program: Outside, level: int, seq: int | None) -> None:
        self._program, self._level, self._seq = program, level, seq

    def show(self) -> None:
        """Show a picture."""
        fields = {"utime": time.time_ns() // 1000, "seq": self._seq or 0, "rows": 24, "cols": 32, "channels": 1}
        self._program.say_bytes("CAMERA", IMAGE.encode({**fields, "step_px": 0, "data": bytes([self._level]) * 768}))
        if self._seq is not None:
            self._seq += 1


def speeds(program: Outside) -> list[float]:
    """Return the speeds that left for the base, without repetitions."""
    return [v_mps for v_mps, _ in groupby(v for _, v in program.speeds("BASE"))]


def show_until(program: Outside, cameras: Sequence[Camera], holds: Callable[[], bool], for_s: float = 0.0) -> None:
    """Let cameras show pictures until something holds, and for a time at least."""
    end_s = time.monotonic() + for_s

    def is_over() -> bool:
        for camera in cameras:
            camera.show()
            time.sleep(0.02)
        return holds() and time.monotonic() >= end_s

    program.wait_for(is_over)


def told(run: Live) -> str:
    return "\n".join(run.notices)


def test_a_standby_does_not_stop_the_robot_and_takes_over_through_one_stop(live: Begin, outside: Program) -> None:
    program, other = outside("BASE"), outside()
    active, standby = Camera(program, 7, 5230), Camera(other, 9, 17)
    run = live(GUARDED)
    show_until(program, [active], lambda: speeds(program)[-1:] == [7.0])
    show_until(program, [active], lambda: True, ACCEPTED_S)
    show_until(program, [active, standby], lambda: "second writer: seq " in told(run), 1.0)
    assert speeds(program)[-1:] == [7.0]
    show_until(program, [standby], lambda: speeds(program)[-1:] == [9.0])
    show_until(program, [standby, active], lambda: speeds(program)[-1:] == [9.0], 1.5)
    _, log = run.stop()
    assert [v for v in speeds(program) if v] == [7.0, 9.0], "each drove once: a single stop lies between them"
    status = [state for _, _, state in log.messages("guard.state") if isinstance(state, GuardState)]
    assert any("fault" in state.causes for state in status)


def test_before_one_was_accepted_the_robot_stands_and_both_are_named(live: Begin, outside: Program) -> None:
    program, other = outside("BASE"), outside()
    cameras = Camera(program, 7, 5230), Camera(other, 9, 17)
    run = live(GUARDED)
    program.wait_for(lambda: bool(program.of("BASE")))
    show_until(program, cameras, lambda: "two writers: seq " in told(run), 1.5)
    standing = len(program.of("BASE"))
    show_until(program, cameras, lambda: len(program.of("BASE")) > standing + 10)
    assert {v for _, v in program.speeds("BASE")[standing:]} == {0.0}
    show_until(program, cameras[1:], lambda: speeds(program)[-1:] == [9.0])
    run.stop()


def test_two_that_do_not_number_their_pictures_are_told_by_their_addresses(live: Begin, outside: Program) -> None:
    program, other = outside("BASE"), outside()
    cameras = Camera(program, 7, None), Camera(other, 9, None)
    run = live(GUARDED)
    show_until(program, cameras[:1], lambda: speeds(program)[-1:] == [7.0], ACCEPTED_S)
    show_until(program, cameras, lambda: "2 writers without sequence numbers: " in told(run), 1.0)
    standing = len(program.of("BASE"))
    show_until(program, cameras, lambda: len(program.of("BASE")) > standing + 10)
    assert {v for _, v in program.speeds("BASE")[standing:]} == {0.0}
    assert "(pid " in told(run)
    show_until(program, cameras[1:], lambda: speeds(program)[-1:] == [9.0])
    run.stop()


def test_a_driver_that_starts_again_is_not_a_second_writer(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    before, again = Camera(program, 7, 5230), Camera(program, 9, 0)
    run = live(GUARDED)
    show_until(program, [before], lambda: speeds(program)[-1:] == [7.0])
    show_until(program, [before], lambda: True, ACCEPTED_S)
    show_until(program, [again], lambda: "restarted: seq is " in told(run) and speeds(program)[-1:] == [9.0])
    _, log = run.stop()
    assert [v for v in speeds(program) if v] == [7.0, 9.0], "a stop lies between them"
    states = [state for _, _, state in log.messages("guard.state") if isinstance(state, GuardState)]
    assert any("fault" in state.causes for state in states)


BESIDE = GUARDED.replace(
    "stages:",
    """  goal.twist: {channel: GOAL, type: graphnav_lcm.twist_t, max_age_s: 0.3}
stages:
  world: {use: probe.ticker, with: {rate_hz: 50}, in: {command: goal.twist}}""",
)


def test_a_takeover_of_an_input_that_no_command_is_made_of_stops_nothing(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    camera = Camera(program, 7, 0)
    run = live(BESIDE)
    show_until(program, [camera], lambda: speeds(program)[-1:] == [7.0])
    for seq in (100, 101, 0):
        goal = Twist(v_mps=float(seq), omega_radps=0.0)
        program.say_bytes("GOAL", encode(goal, time.time_ns() // 1000, seq))
        show_until(program, [camera], lambda: True, 1.2 if seq else 0.3)
    _, log = run.stop()
    assert [m.v_mps for _, _, m in log.messages("goal.twist") if isinstance(m, Twist)] == [100.0, 101.0, 0.0]
    driving = speeds(program)[speeds(program).index(7.0) :]
    assert driving in ([7.0], [7.0, 0.0]), "the zero is the stop at the end of the run"


def test_a_stop_counts_from_any_program(live: Begin, outside: Program) -> None:
    program, other = outside("BASE"), outside()
    camera = Camera(program, 7, None)
    run = live(GUARDED)
    show_until(program, [camera], lambda: speeds(program)[-1:] == [7.0])
    for sender, engaged, speed in (
        (program, True, 0.0),
        (other, False, 7.0),
        (other, True, 0.0),
        (program, False, 7.0),
    ):
        sender.say_bytes("STOP", encode(Stop(engaged=engaged), 5, 0))
        show_until(program, [camera], lambda speed=speed: speeds(program)[-1:] == [speed])  # type: ignore[misc]
    run.stop()
