"""Bad messages are counted by reason, never used, and never end a run."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from graphnav import Goal, Image, Odometry, Stop, Twist
from graphnav.core.codec import decode, encode

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

LISTENING = """
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  base.twist: {channel: BASE, type: graphnav_lcm.twist_t}
stages:
  see: {use: probe.brightness, in: {image: camera.image}}
  world: {use: probe.ticker, with: {rate_hz: 50}, in: {command: base.twist}}
outputs: {see.twist: {channel: SPEED, motor: false}}
"""


def rejected(run: Live, name: str) -> dict[str, int]:
    """End a run and return how many messages of an input were rejected, by reason."""
    summary, log = run.stop()
    assert summary.outcome == "stopped", summary.failure
    assert log.count("graphnav.status") >= 0
    assert summary.live is not None
    found = next(one for one in summary.live["inputs"] if one["name"] == name)
    return dict(zip(found["reasons"], found["rejected"], strict=True))


def show_until_heard(program: Outside, level: int) -> None:
    """Publish pictures until one was stepped with."""
    while (utime := program.show("CAMERA", level)) not in dict(program.speeds("SPEED")):
        time.sleep(0.05)
        if utime in dict(program.speeds("SPEED")):
            return


def test_each_kind_of_bad_message_is_counted_and_good_ones_still_count(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(LISTENING)
    show_until_heard(program, 5)
    now = time.time_ns() // 1000
    picture = encode(Image(pixels=np.full((24, 32), 200, np.uint8)), now, 10_000)
    program.say_bytes("CAMERA", b"")
    program.say_bytes("CAMERA", b"garbage")
    program.say_bytes("CAMERA", encode(Twist(v_mps=1.0, omega_radps=0.0), now, 0))
    program.say_bytes("CAMERA", picture[:-10])
    program.say_bytes("CAMERA", picture + b"0")
    program.say("CAMERA", Image(pixels=np.full((24, 32), 200, np.uint8), step_px=-1))
    program.show("CAMERA", 200, size=(12, 16))
    time.sleep(0.1)
    program.show("CAMERA", 200, utime=1)
    time.sleep(0.1)
    show_until_heard(program, 6)
    assert 200.0 not in {v for _, v in program.speeds("SPEED")}
    counts = rejected(run, "camera.image")
    assert counts["wrong type"] == 3
    assert counts["undecodable"] == 2
    assert counts["unreadable"] == 1
    assert counts["wrong size"] == 1
    assert sum(counts.values()) >= 7


def test_stamps_that_run_backwards_are_counted_and_not_acted_upon(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(LISTENING)
    show_until_heard(program, 5)
    newest = time.time_ns() // 1000
    for k in range(1, 9):
        program.show("CAMERA", 200, utime=newest - 20_000_000 - 10_000 * k)
        time.sleep(0.02)
    show_until_heard(program, 6)
    assert 200.0 not in {v for _, v in program.speeds("SPEED")}
    counts = rejected(run, "camera.image")
    assert counts.get("backwards", 0) + counts.get("jumped", 0) == 8


def test_a_second_writer_is_counted_and_not_acted_upon_while_the_first_one_sends(live: Begin, outside: Program) -> None:
    first, second = outside("SPEED"), outside()
    run = live(LISTENING.replace("image_t}", "image_t, max_age_s: 2}"))
    accepted_s = time.monotonic() + 2.1
    while time.monotonic() < accepted_s:
        show_until_heard(first, 5)
    for k in range(20):
        first.show("CAMERA", 6)
        time.sleep(0.02)
        other = encode(Image(pixels=np.full((24, 32), 200, np.uint8)), time.time_ns() // 1000, 5000 + k)
        second.say_bytes("CAMERA", other)
        time.sleep(0.02)
    show_until_heard(first, 7)
    assert {v for _, v in first.speeds("SPEED")} <= {5.0, 6.0, 7.0}
    assert rejected(run, "camera.image")["second writer"] == 20


def test_a_flood_of_a_second_writer_neither_drives_nor_silences_the_first(live: Begin, outside: Program) -> None:
    first, second = outside("TICK"), outside()
    driven = LISTENING.replace("twist_t}", "twist_t, max_age_s: 2}")
    run = live(driven.replace("outputs: {", "outputs: {world.goal: {channel: TICK}, "))

    def is_heard() -> bool:
        first.say("BASE", Twist(v_mps=1.0, omega_radps=0.0))
        return any(decode(Goal, data)[2].distance_m < 10 for data in first.of("TICK"))

    first.wait_for(is_heard)
    accepted_s = time.monotonic() + 2.1
    first.wait_for(lambda: is_heard() and time.monotonic() > accepted_s)
    for k in range(5000):
        if k % 50 == 0:
            first.say("BASE", Twist(v_mps=1.0, omega_radps=0.0))
            time.sleep(0.01)
        stray = encode(Twist(v_mps=-9.0, omega_radps=0.0), time.time_ns() // 1000, 50_000 + k)
        second.say_bytes("BASE", stray)
    counts = rejected(run, "base.twist")
    _, log = run.finish()
    assert counts["second writer"] + counts.get("flood", 0) >= 1000
    assert {m.v_mps for _, _, m in log.messages("base.twist") if isinstance(m, Twist)} == {1.0}
    assert log.count("base.twist") >= 10


def test_a_number_that_is_not_finite_is_not_acted_upon(live: Begin, outside: Program) -> None:
    program = outside()
    run = live(LISTENING)
    for k in range(30):
        program.say("BASE", Twist(v_mps=float("nan") if k % 2 else 1.0, omega_radps=0.0))
        time.sleep(0.02)
    assert rejected(run, "base.twist")["not finite"] >= 10


def test_repeated_stamps_are_counted_and_the_message_grows_old(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(LISTENING)
    show_until_heard(program, 5)
    stamp = time.time_ns() // 1000
    for _ in range(10):
        program.show("CAMERA", 9, utime=stamp)
        time.sleep(0.02)
    program.wait_for(lambda: stamp in dict(program.speeds("SPEED")))
    assert len([1 for utime, _ in program.speeds("SPEED") if utime == stamp]) == 1
    assert rejected(run, "camera.image")["repeated"] >= 5


def test_a_flood_is_survived_and_its_messages_are_not_queued(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(LISTENING)
    show_until_heard(program, 5)
    for _ in range(3000):
        program.say_bytes("BASE", b"garbage without a reader")
    standing = encode(Odometry(x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0), 1, 1)
    for _ in range(3000):
        program.say_bytes("BASE", standing)
    show_until_heard(program, 6)
    assert rejected(run, "base.twist")["wrong type"] >= 1000


def test_a_stop_of_any_sender_counts_and_whatever_its_stamp_and_number(live: Begin, outside: Program) -> None:
    program = outside("GUARDED")
    run = live(
        """
        inputs:
          camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
          operator.stop: {channel: STOP, type: graphnav_lcm.stop_t}
        stages:
          see: {use: probe.brightness, in: {image: camera.image}}
          guard: {use: control.guard, every_ms: 20, in: {command: see.twist, stop: operator.stop}}
        outputs: {guard.twist: {channel: GUARDED, motor: true}}
        """
    )

    def is_moving() -> bool:
        program.show("CAMERA", 3)
        time.sleep(0.02)
        return program.speeds("GUARDED")[-1:] != [] and program.speeds("GUARDED")[-1][1] == 3.0

    program.wait_for(is_moving)
    for stamp, seq in ((10**15, 50), (5, 0), (10**15, 7)):
        program.say_bytes("STOP", encode(Stop(engaged=True), stamp, seq))
        program.wait_for(lambda: not is_moving())
        program.say_bytes("STOP", encode(Stop(engaged=False), 1, 3))
        program.wait_for(is_moving)
    assert not rejected(run, "operator.stop")
