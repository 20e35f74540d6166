"""The tap: everybody can watch a run, and the run does not notice."""

from __future__ import annotations

import queue
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from graphnav.core.bus import Bus, fits_packet
from graphnav.core.codec import codec_of, decode, encode, lcm_name
from graphnav.core.messages import About, Flow, Image, Message, Twist
from graphnav.core.tap import Tap

RNG = np.random.default_rng(11)
TYPES: dict[str, type[Message]] = {"flow.flow": Flow, "robot.image": Image, "control.twist": Twist}
SAID = About("stages: {}\n", "", "", 7, tuple(TYPES), tuple(lcm_name(m.lcm_class) for m in TYPES.values()))


def flow_of(rows: int, cols: int) -> Flow:
    """Return a flow with something in it."""
    uv_px = RNG.normal(size=(rows, cols, 2)).astype(np.float32)
    return Flow(uv_px=uv_px, valid=RNG.integers(0, 2, (rows, cols), dtype=np.uint8), interval_us=100_000, step_px=2)


class Listener:
    """Another program on the group."""

    def __init__(self, group: str) -> None:
        self.received: list[tuple[str, bytes]] = []
        self._bus = Bus(group)
        self._bus.subscribe_all(lambda channel, data: self.received.append((channel, data)))

    def wait_for(self, enough: Callable[[list[tuple[str, bytes]]], Any]) -> None:
        """Listen until what was received is enough."""
        while not enough(self.received):
            assert self._bus.handle(10.0), f"silence after {[channel for channel, _ in self.received]}"

    def on(self, channel: str) -> list[bytes]:
        """Return what was received on one channel."""
        return [data for name, data in self.received if name == channel]


def test_small_messages_arrive_as_they_are(group: str) -> None:
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    sent = [("control.twist", encode(Twist(0.1 * k, 0.2), 100_000 * k, k)) for k in range(20)]
    for k, (channel, data) in enumerate(sent):
        tap.write(channel, 100_000 * k, data)
    listener.wait_for(lambda received: len(received) >= len(sent))
    tap.close()
    assert listener.received == sent
    assert tap.dropped == 0


@pytest.mark.parametrize(("rows", "cols", "step"), [(120, 160, 2), (480, 640, 7), (60, 80, 1)])
def test_a_grid_above_one_packet_is_thinned(group: str, rows: int, cols: int, step: int) -> None:
    flow = flow_of(rows, cols)
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    tap.announce(SAID)
    for seq in range(2):
        tap.write("flow.flow", 5, encode(flow, 5, seq))
    listener.wait_for(lambda _: len(listener.on("flow.flow")) >= 2)
    tap.close()
    for seq, data in enumerate(listener.on("flow.flow")):
        assert fits_packet("flow.flow", data)
        utime, number, thin = decode(Flow, data)
        assert (utime, number) == (5, seq)
        assert thin.step_px == 2 * step
        assert thin.interval_us == 100_000
        np.testing.assert_array_equal(thin.uv_px, flow.uv_px[::step, ::step])
        np.testing.assert_array_equal(thin.valid, flow.valid[::step, ::step])


def test_a_picture_above_one_packet_is_thinned(group: str) -> None:
    image = Image(pixels=RNG.integers(0, 255, (240, 320, 3), dtype=np.uint8))
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    tap.announce(SAID)
    tap.write("robot.image", 5, encode(image, 5, 6))
    listener.wait_for(lambda _: listener.on("robot.image"))
    tap.close()
    thin = decode(Image, listener.on("robot.image")[0])[2]
    np.testing.assert_array_equal(thin.pixels, image.pixels[:: thin.step_px, :: thin.step_px])


def test_in_full_all_bytes_are_sent(group: str) -> None:
    data = encode(flow_of(120, 160), 5, 6)
    listener, tap = Listener(group), Tap("full", "run-1", group)
    tap.write("flow.flow", 5, data)
    listener.wait_for(lambda received: received)
    tap.close()
    assert listener.received == [("flow.flow", data)]


def test_of_a_run_at_full_speed_some_pictures_are_sent_with_what_was_made_from_them(group: str) -> None:
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    image = Image(pixels=RNG.integers(0, 255, (60, 80), dtype=np.uint8))
    begin_s = time.monotonic()
    for k in range(200):
        tap.write("control.twist", k, encode(Twist(0.1, 0.2), k, k))
        tap.write("robot.image", k, encode(image, k, k))
        tap.write("flow.image", k, encode(image, k, k))
    elapsed_s = time.monotonic() - begin_s
    listener.wait_for(lambda _: len(listener.on("control.twist")) == 200)
    tap.close()
    listener.wait_for(lambda _: len(listener.on("flow.image")) + len(listener.on("robot.image")) == 400 - tap.dropped)
    stamps = [decode(Image, data)[0] for data in listener.on("robot.image")]
    assert stamps == [decode(Image, data)[0] for data in listener.on("flow.image")]
    assert stamps[:16] == list(range(16))
    assert len(stamps) <= 18 + 32 * elapsed_s


def test_in_full_every_picture_is_sent(group: str) -> None:
    listener, tap = Listener(group), Tap("full", "run-1", group)
    image = Image(pixels=RNG.integers(0, 255, (60, 80), dtype=np.uint8))
    for k in range(60):
        tap.write("robot.image", k, encode(image, k, k))
    listener.wait_for(lambda received: len(received) == 60)
    tap.close()
    assert tap.dropped == 0


def test_late_comers_hear_what_runs(group: str) -> None:
    tap = Tap("thin", "run-1", group)
    tap.announce(SAID)
    listener = Listener(group)
    listener.wait_for(lambda received: received)
    tap.close()
    assert listener.received[0][0] == About.CHANNEL
    about = decode(About, listener.received[0][1])[2]
    assert about.run_id == "run-1"
    assert (about.graph_yaml, about.channels, about.types) == (SAID.graph_yaml, SAID.channels, SAID.types)


def test_late_comers_hear_what_was_said_once_and_no_old_news(group: str) -> None:
    tap = Tap("thin", "run-1", group)
    tap.announce(SAID)
    once = encode(Twist(0.1, 0.2), 0, 0)
    often = [encode(Twist(0.1, 0.2), k, k) for k in range(2)]
    early = Listener(group)
    tap.write("once", 0, once)
    for k, data in enumerate(often):
        tap.write("often", k, data)
    early.wait_for(lambda _: len(early.on("often")) >= len(often))
    late = Listener(group)
    late.wait_for(lambda _: len(late.on("once")) >= 2)
    tap.close()
    assert set(late.on("once")) == {once}
    assert not late.on("often")


def test_two_runs_on_one_group_notice_each_other(group: str) -> None:
    notices: dict[str, queue.Queue[str]] = {name: queue.Queue() for name in ("run-1", "run-2")}
    taps = [Tap("thin", name, group, notices[name].put) for name in notices]
    for tap in taps:
        tap.announce(SAID)
    said = {name: notices[name].get(timeout=10) for name in notices}
    for tap in taps:
        tap.close()
    assert said["run-1"].startswith(
        f"run run-1 and run run-2 both publish {', '.join(sorted(SAID.channels)[:3])} on udpm:"
    )
    assert said["run-2"].startswith("run run-2 and run run-1 both publish ")
    assert all(notice.empty() for notice in notices.values())


def test_runs_whose_channels_differ_share_a_group_in_peace(group: str) -> None:
    notices: queue.Queue[str] = queue.Queue()
    first, second, third = (Tap("thin", f"run-{k}", group, notices.put) for k in range(3))
    first.announce(SAID, shareable=SAID.channels)
    second.announce(replace(SAID, channels=("base.twist",), types=("graphnav_lcm.twist_t",)))
    third.announce(replace(SAID, channels=("base.twist",), types=("graphnav_lcm.twist_t",)))
    told = {notices.get(timeout=10).partition(" and ")[0] for _ in range(2)}
    for tap in (first, second, third):
        tap.close()
    assert told == {"run run-1", "run run-2"}
    assert notices.empty()


def test_what_cannot_be_sent_in_time_is_dropped_and_counted(group: str) -> None:
    tap = Tap("full", "run-1", group)
    data = bytes(1_000_000)
    for k in range(60):
        tap.write("x", k, data)
    assert tap.dropped >= 30
    tap.close()


def test_what_cannot_be_thinned_or_sent_is_counted_and_the_tap_goes_on(group: str) -> None:
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    tap.announce(SAID)
    tap.write("flow.flow", 1, bytes(100_000))
    tap.write("x" * 64, 2, b"")
    tap.write("control.twist", 3, encode(Twist(0.1, 0.2), 3, 0))
    listener.wait_for(lambda _: listener.on("control.twist"))
    tap.close()
    assert tap.dropped == 2


def test_what_waits_is_sent_before_the_tap_closes(group: str) -> None:
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    for k in range(10):
        tap.write("x", k, b"%d" % k)
    tap.close()
    listener.wait_for(lambda received: len(received) >= 10)
    assert listener.on("x") == [b"%d" % k for k in range(10)]


def test_a_foreign_message_on_the_reserved_channel_harms_nothing(group: str) -> None:
    listener, tap = Listener(group), Tap("thin", "run-1", group)
    Bus(group).publish(About.CHANNEL, b"garbage")
    listener.wait_for(lambda received: received)
    tap.write("x", 1, b"still here")
    listener.wait_for(lambda _: listener.on("x"))
    tap.close()


def test_without_a_multicast_route_it_says_the_command() -> None:
    unshare = shutil.which("unshare")
    if unshare is None or subprocess.run([unshare, "-rn", "true"], capture_output=True, check=False).returncode:
        pytest.skip("this machine gives no network namespace to try it in")
    command = [
        unshare,
        "-rn",
        sys.executable,
        "-c",
        "from graphnav.core.tap import Tap; Tap('thin', 'run-1', 'udpm://')",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "no multicast route" in done.stderr
    assert "ip route add 224.0.0.0/4 dev lo" in done.stderr


def test_every_grid_message_can_be_thinned() -> None:
    for message_class in (Flow, Image):
        codec = codec_of(message_class.lcm_class)
        assert set(message_class.grid) <= {*codec.fields, "pixels"}
