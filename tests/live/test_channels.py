"""Inputs are stepped with, named outputs are sent, and stamps are kept."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Odometry, Recording, Twist

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

SEEING = """
run: {until_s: 30}
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  see: {use: probe.brightness, in: {image: camera.image}}
outputs: {see.twist: {channel: SPEED, motor: false}}
"""


def test_a_message_from_outside_is_stepped_with_and_the_answer_leaves_with_its_stamp(
    live: Begin, outside: Program
) -> None:
    program = outside("SPEED")
    run = live(SEEING)
    sent: list[int] = []
    while len(program.of("SPEED")) < 5:
        sent.append(program.show("CAMERA", len(sent)))
        time.sleep(0.02)
    summary, log = run.stop()
    assert summary.outcome == "stopped"
    answered = program.speeds("SPEED")
    assert all((sent.index(utime), v) == (v, v) for utime, v in answered)
    assert {utime for utime, _, _ in log.messages("see.twist")} >= {utime for utime, _ in answered}
    assert log.channels["camera.image"] is not None


def test_a_jittering_camera_keeps_its_stamps_through_to_the_log(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(SEEING.replace("until_s: 30", "until_s: 30, record: all"))
    while not program.of("SPEED"):
        program.show("CAMERA", 0)
        time.sleep(0.01)
    begin = time.time_ns() // 1000
    sent = [begin + 50_000 * k + (-1) ** k * 900 * k for k in range(10)]
    for utime in sent:
        program.show("CAMERA", 1, utime)
        program.wait_for(partial(_heard, program, utime))
    _, log = run.stop()
    assert [utime for utime, _, _ in log.messages("camera.image")][-10:] == sent
    assert [utime for utime, _, _ in log.messages("see.twist")][-10:] == sent


def test_a_slow_stage_steps_with_the_newest_frame_and_the_others_are_counted(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(SEEING.replace("use: probe.brightness", "use: probe.brightness, with: {dawdle_s: 0.3}"))
    begin_s = time.monotonic()
    sent: list[int] = []
    while len(program.of("SPEED")) < 5 and time.monotonic() < begin_s + 20:
        sent.append(program.show("CAMERA", len(sent) % 250))
        time.sleep(0.03)
    summary, _ = run.stop()
    used = [sent.index(utime) for utime, _ in program.speeds("SPEED")]
    assert all(later - earlier >= 4 for earlier, later in pairwise(used[1:]))
    assert summary.live is not None
    overtaken = {edge["name"]: edge["overtaken"] for edge in summary.live["edges"]}
    assert overtaken["see.image"] >= 3 * len(used[1:])
    assert summary.stages["see"].dropped == overtaken["see.image"]
    assert any(line.startswith("late: ") and "see.image" in line for line in run.notices)


def test_a_queue_that_keeps_all_steps_with_every_frame_in_order(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(
        SEEING.replace("use: probe.brightness", "use: probe.brightness, with: {dawdle_s: 0.05}")
        + "queues: {see.image: {keep: all}}\n"
    )
    first = program.show("CAMERA", 0)
    while not program.of("SPEED"):
        first = program.show("CAMERA", 0)
        time.sleep(0.2)
    n_before = len(program.of("SPEED"))
    sent = [program.show("CAMERA", k) for k in range(20)]
    program.wait_for(lambda: len(program.of("SPEED")) >= n_before + 20)
    run.stop()
    assert first < sent[0]
    assert [utime for utime, _ in program.speeds("SPEED")][-20:] == sent


def test_a_timed_stage_steps_with_the_newest_set_and_with_none_before_it(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    run = live(
        """
        inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
        stages:
          see: {use: probe.brightness, in: {image: camera.image}}
          guard: {use: probe.pass, every_ms: 20, in: {command: see.twist, image: camera.image}}
        outputs: {guard.twist: {channel: BASE, motor: true}}
        """
    )
    program.wait_for(lambda: len(program.of("BASE")) >= 5)
    assert {v for _, v in program.speeds("BASE")} == {0.0}
    program.show("CAMERA", 7)
    program.wait_for(lambda: 7.0 in {v for _, v in program.speeds("BASE")})
    program.wait_for(lambda: program.speeds("BASE")[-1][1] == 0.0)  # the command is older than 0.3 s
    summary, log = run.stop()
    stamps = [utime for utime, _, _ in log.messages("guard.twist")]
    assert stamps == sorted(set(stamps))
    ages = [m.omega_radps for _, _, m in log.messages("guard.twist") if isinstance(m, Twist) and m.v_mps == 7.0]
    assert ages == sorted(ages)
    assert len(ages) >= 3
    assert summary.live is not None
    assert summary.live["outputs"][0]["latency_p50_ms"] < 1e3


def test_a_firing_waits_for_the_sample_after_its_stamp(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(
        """
        inputs:
          camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
          base.odometry: {channel: ODOMETRY, type: graphnav_lcm.odometry_t}
        stages:
          gather: {use: probe.gather, in: {image: camera.image, odometry: base.odometry}}
        outputs: {gather.goal: {channel: SPEED}}
        """
    )
    standing = Odometry(x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0)
    for _ in range(40):
        frame = program.show("CAMERA", 1)
        for k in range(4):
            program.say("ODOMETRY", standing, frame - 12_000 + 5000 * k)
        time.sleep(0.03)
    _, log = run.stop()
    ahead = [m.distance_m for _, _, m in log.messages("gather.goal")]  # type: ignore[attr-defined]
    counts = [m.bearing_rad for _, _, m in log.messages("gather.goal")]  # type: ignore[attr-defined]
    assert len(ahead) >= 20
    assert sum(a >= 0.002 for a in ahead) >= 0.9 * len(ahead)
    assert sum(counts) >= 3 * len(ahead)


def test_a_recorded_channel_is_played_at_its_stamps_and_its_end_is_the_runs(
    live: Begin, outside: Program, tmp_path: Path
) -> None:
    program = outside("SPEED")
    run = live(SEEING.replace("until_s: 30", "until_s: 30, record: all"), "recorded")
    for level in range(12):
        program.show("CAMERA", level)
        time.sleep(0.04)
    run.stop()
    begin_s = time.monotonic()
    again = live(
        f"""
        run: {{record: all}}
        inputs: {{camera.image: {{log: {tmp_path}/recorded/run.lcmlog, type: graphnav_lcm.image_t}}}}
        stages:
          see: {{use: probe.brightness, in: {{image: camera.image}}}}
        queues: {{see.image: {{keep: all}}}}
        """,
        "again",
    )
    summary, log = again.finish()
    assert summary.outcome == "end"
    with Recording(tmp_path / "recorded" / "run.lcmlog") as recorded:
        played = [utime for utime, _, _ in recorded.messages("camera.image")]
    assert [utime for utime, _, _ in log.messages("see.twist")] == played
    assert time.monotonic() - begin_s >= (played[-1] - played[0]) / 1e6


def test_a_command_from_outside_moves_what_runs_by_the_clock(live: Begin, outside: Program) -> None:
    program = outside("TICK")
    run = live(
        """
        inputs: {base.twist: {channel: BASE, type: graphnav_lcm.twist_t}}
        stages:
          world: {use: probe.ticker, with: {rate_hz: 100, last: 150}, in: {command: base.twist}}
        """
    )
    for _ in range(10):
        program.say("BASE", Twist(v_mps=1.0, omega_radps=0.0))
        time.sleep(0.02)
    summary, log = run.finish()
    assert summary.outcome == "goal"
    ages = [m.distance_m for _, _, m in log.messages("world.goal")]  # type: ignore[attr-defined]
    assert min(ages) < 0.1
    assert ages[-1] > 0.3
    assert log.count("graphnav.status") >= 1


def _heard(program: Outside, utime: int) -> bool:
    return utime in [stamp for stamp, _ in program.speeds("SPEED")]
