"""Stamps of wrong units and clocks are named as that, not by what follows from them."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from graphnav import Odometry, Status
from graphnav.core.runner.join import MAX_UNMATCHED

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

PERIOD_S = 0.02


def wall_us() -> int:
    return time.time_ns() // 1000


STAMPS: dict[str, Callable[[], int]] = {
    "SECONDS": lambda: wall_us() // 1_000_000,
    "MILLISECONDS": lambda: wall_us() // 1000,
    "NANOSECONDS": time.time_ns,
    "ZERO": lambda: 0,
    "BOOT": lambda: time.monotonic_ns() // 1000,
    "BOOT_NS": time.monotonic_ns,
    "LATE": lambda: wall_us() - 420_000,
    "LOCAL": lambda: wall_us() + 7_200_000_000,
    "RIGHT": wall_us,
}
UNITS = {
    "SECONDS": "stamps look like seconds: utime is in microseconds, multiply by 1000000",
    "MILLISECONDS": "stamps look like milliseconds: utime is in microseconds, multiply by 1000",
    "NANOSECONDS": "stamps look like nanoseconds: utime is in microseconds, divide by 1000",
    "ZERO": "utime is 0: the sender sets no stamp",
    "BOOT_NS": "stamps look like nanoseconds of CLOCK_MONOTONIC: utime is in microseconds, divide by 1000",
}
CLOCKS = {
    "BOOT": "stamps are of CLOCK_MONOTONIC, the time since boot: only stamps of that clock join them",
    "LATE": "its clock is 0.42 s behind this machine's, or it takes that long: counts as age, since it is below",
    "LOCAL": "its clock is 7200 s ahead of this machine's (2 h: local time in place of UTC?), which does not count",
}


def test_wrong_units_and_clocks_are_named(live: Begin, outside: Program) -> None:
    graph = ["run: {record: all}", "inputs:"]
    graph += [f"  {c.lower()}.image: {{channel: {c}, type: graphnav_lcm.image_t, max_age_s: 0.6}}" for c in STAMPS]
    graph += [
        "stages:",
        *(f"  s{c.lower()}: {{use: probe.brightness, in: {{image: {c.lower()}.image}}}}" for c in STAMPS),
    ]
    program, run = outside(), live("\n".join(graph))

    def are_told() -> bool:
        for channel, stamp in STAMPS.items():
            program.show(channel, 100, stamp())
        time.sleep(PERIOD_S)
        return len([line for line in run.notices if line.startswith("clock: ")]) >= len(UNITS | CLOCKS)

    program.wait_for(are_told)
    _, log = run.stop()
    for channel, said in (UNITS | CLOCKS).items():
        assert [line for line in run.notices if line.startswith(f"clock: {channel.lower()}.image on {channel}: {said}")]
    assert not [line for line in run.notices if line.startswith(("late: ", "overtaken: ", "not used: "))]
    statuses = [one for _, _, one in log.messages("graphnav.status") if isinstance(one, Status)]
    told = {one["channel"]: one["fault"] or one["clock"] for one in statuses[-1].inputs}
    assert all(told[channel].startswith(said) for channel, said in (UNITS | CLOCKS).items())
    assert not told["RIGHT"]


JOINED = """
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  base.odometry: {channel: ODOMETRY, type: graphnav_lcm.odometry_t}
  left.image: {channel: LEFT, type: graphnav_lcm.image_t}
stages:
  gather: {use: probe.gather, in: {image: camera.image, odometry: base.odometry}}
  see: {use: probe.brightness, in: {image: camera.image}}
  beside: {use: probe.brightness, in: {image: left.image}}
  both: {use: probe.both, in: {a: see.twist, b: beside.twist}}
"""


def test_stamps_that_cannot_be_joined_are_told_with_their_offset(live: Begin, outside: Program) -> None:
    program, run = outside(), live(JOINED)
    wanted = (
        "clock: camera.image: stamps of CAMERA are 12.30 s ahead of those of ODOMETRY: gather cannot join them\n",
        "clock: camera.image: stamps of CAMERA are 12.30 s ahead of those of LEFT: both cannot join them\n",
        "clock: both joins nothing: a, b have no stamp in common, the nearest differ by 1",
    )
    sent = 0

    def are_told() -> bool:
        nonlocal sent
        program.show("CAMERA", 100, wall_us() + 12_300_000)
        program.show("LEFT", 100, wall_us())
        program.say("ODOMETRY", Odometry(x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0))
        sent += 1
        time.sleep(PERIOD_S)
        return all(any(line.startswith(said) for line in run.notices) for said in wanted)

    program.wait_for(are_told)
    assert sent >= MAX_UNMATCHED
    run.stop()
    assert not [line for line in run.notices if line.startswith(("late: ", "overtaken: "))]
