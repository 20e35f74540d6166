"""A live run says on its terminal, and keeps in its summary, what is lost, what hangs and who else drives."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from graphnav import Twist
from graphnav.core.errors import UserError
from graphnav.core.machine.receive_buffer import ReceiveBuffer

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

GUARDED = """
inputs: {{camera.image: {{channel: CAMERA, type: graphnav_lcm.image_t}}}}
stages:
  see: {{use: probe.brightness, with: {{dawdle_s: {dawdle_s}}}, in: {{image: camera.image}}}}
  guard: {{use: probe.pass, every_ms: {every_ms}, in: {{command: see.twist, image: camera.image}}}}
outputs: {{guard.twist: {{channel: BASE, motor: true}}}}
"""


def told(run: Live, begins: str) -> bool:
    """Whether a run has told something that begins so."""
    return any(line.startswith(begins) for line in run.notices)


def test_an_input_that_never_speaks_is_told(live: Begin, outside: Program) -> None:
    program = outside()
    run = live(GUARDED.format(dawdle_s=0, every_ms=50))
    program.wait_for(lambda: told(run, "silent: camera.image has had no message on CAMERA for "))
    summary, _ = run.stop()
    assert any(line.startswith("silent: camera.image") for line in summary.notices)


def test_a_channel_that_carries_the_type_of_a_silent_input_is_named(live: Begin, outside: Program) -> None:
    program = outside()
    run = live(GUARDED.format(dawdle_s=0, every_ms=50))

    def named() -> bool:
        program.show("CAM0", 1)
        program.say("SPEED", Twist(v_mps=1.0, omega_radps=0.0))
        time.sleep(0.05)
        return told(run, "silent: camera.image has had no message on CAMERA for ")

    program.wait_for(named)
    (line,) = (line for line in run.notices if line.startswith("silent: "))
    assert re.search(r" s; CAM0 carries graphnav_lcm\.image_t at \d+(\.\d+)? Hz$", line)
    run.stop()


def test_an_input_whose_messages_are_rejected_is_not_silent(live: Begin, outside: Program) -> None:
    program = outside("graphnav.status")
    run = live(GUARDED.format(dawdle_s=0, every_ms=50))
    end_s = time.monotonic() + 3.5

    def refused() -> bool:
        program.say("CAMERA", Twist(v_mps=1.0, omega_radps=0.0))
        time.sleep(0.05)
        return told(run, "not used: ") and time.monotonic() > end_s

    program.wait_for(refused)
    assert not told(run, "silent: ")
    line = next(line for line in run.notices if line.startswith("not used: "))
    assert line.endswith(" wrong type: the messages are graphnav_lcm.twist_t, expected graphnav_lcm.image_t")
    run.stop()


def test_messages_that_are_not_used_are_told_with_the_reason(live: Begin, outside: Program) -> None:
    program = outside()
    run = live(GUARDED.format(dawdle_s=0, every_ms=50))

    def refused() -> bool:
        program.say("CAMERA", Twist(v_mps=1.0, omega_radps=0.0))
        return told(run, "not used: ")

    program.wait_for(refused)
    assert "wrong type" in next(line for line in run.notices if line.startswith("not used: "))
    run.stop()


def test_messages_that_never_arrive_are_told_and_counted(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    run = live(GUARDED.format(dawdle_s=0, every_ms=50))

    def sees() -> bool:
        program.show("CAMERA", 1)
        time.sleep(0.02)
        return 1.0 in {v for _, v in program.speeds("BASE")}

    program.wait_for(sees)
    program.lose("CAMERA", 7)
    time.sleep(7 * 0.02)

    def says_so() -> bool:
        program.show("CAMERA", 1)
        time.sleep(0.02)
        return told(run, "lost: 7 messages of camera.image on CAMERA never arrived")

    program.wait_for(says_so)
    summary, _ = run.stop()
    assert summary.live is not None
    assert [one["lost"] for one in summary.live["inputs"] if one["name"] == "camera.image"] == [7]


def test_packets_that_the_receive_buffer_does_not_hold_are_told_with_what_helps(
    live: Begin, outside: Program, group: str
) -> None:
    program = outside("BASE")
    run = live(GUARDED.format(dawdle_s=0, every_ms=50), url=f"{group}&recv_buf_size=16384")
    program.wait_for(lambda: bool(program.of("BASE")))

    def drops() -> bool:
        program.show("CAMERA", 1, size=(960, 1280))
        return told(run, "lost: the kernel dropped ")

    program.wait_for(drops)
    notice = next(line for line in run.notices if line.startswith("lost: the kernel dropped "))
    as_root = (
        f"run as root: sysctl -w net.core.rmem_max={ReceiveBuffer.REQUESTED_BYTES}; "
        if ReceiveBuffer.limit() < ReceiveBuffer.REQUESTED_BYTES
        else ""
    )
    assert re.fullmatch(
        r"lost: the kernel dropped \d+ packets that the receive buffer of 16384 bytes did not hold; "
        r"messages of several packets: (1 MB of )?camera.image on CAMERA\n"
        f"  {as_root}write recv_buf_size={ReceiveBuffer.REQUESTED_BYTES} in the URL, and start again",
        notice,
    )
    summary, _ = run.stop()
    assert summary.live is not None
    assert summary.live["dropped_packets"] >= 3


def test_a_step_that_does_not_end_is_told_while_it_hangs(live: Begin, outside: Program) -> None:
    program = outside()
    run = live(GUARDED.format(dawdle_s=4, every_ms=50))

    def hangs() -> bool:
        program.show("CAMERA", 1)
        time.sleep(0.05)
        return told(run, "hangs: see has been in one step for ")

    program.wait_for(hangs)
    run.stop()


def test_another_program_on_a_motor_channel_is_told(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    run = live(GUARDED.format(dawdle_s=0, every_ms=50))
    program.wait_for(lambda: len(program.of("BASE")) > 3)
    assert not told(run, "another program")

    def drives_too() -> bool:
        program.say("BASE", Twist(v_mps=1.0, omega_radps=0.0))
        return told(run, "another program also sends on BASE: ")

    program.wait_for(drives_too)
    run.stop()


def test_a_fast_timer_starves_no_stage(live: Begin, outside: Program) -> None:
    program = outside("BASE")
    run = live(GUARDED.format(dawdle_s=0, every_ms=1))

    def sees() -> bool:
        program.show("CAMERA", 3)
        time.sleep(0.02)
        return 3.0 in {v for _, v in program.speeds("BASE")}

    program.wait_for(sees)
    run.stop()


@pytest.mark.parametrize("url", ["", "nonsense", "memq://", "udpm://1.2.3.4:7667"])
def test_a_url_where_no_program_can_be_reached_is_refused(load: Callable[[str], object], url: str) -> None:
    from graphnav.core.lcm_url import live_url

    graph = load(GUARDED.format(dawdle_s=0, every_ms=50))
    with pytest.raises(UserError, match="--url"):
        live_url(graph, url)  # type: ignore[arg-type]
