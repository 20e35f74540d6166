"""Rates, losses and silence of a channel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import About, Twist
from graphnav.core.record import LogWriter
from graphnav.watch.feed import RUN_SILENT_S, Feed, Received, Watch
from graphnav.watch.spy import as_text

NASTY = "x\nALL IS WELL\x1b[2J"
SHOWN = r"x\nALL IS WELL\x1b[2J"
SAID = About("stages: {}\n", "", "", 7, (), ())


def twist_at(k: int, period_us: int = 100_000) -> bytes:
    """Return the k-th command."""
    return encode(Twist(0.1, 0.2), period_us * k, k)


def test_the_rate_is_that_of_the_stamps() -> None:
    watch = Watch()
    for k in range(21):
        watch.receive(Received("x", twist_at(k), 7 * k))
    channel = watch.channels["x"]
    assert channel.rate_hz == pytest.approx(10)
    assert channel.wall_rate_hz == pytest.approx(1 / 7)
    assert channel.type_name == "graphnav_lcm.twist_t"


def test_lost_messages_are_counted_and_leave_the_rate_as_it_is() -> None:
    watch = Watch()
    for k in (5, 6, 9, 10, 14):
        watch.receive(Received("x", twist_at(k), k))
    assert watch.channels["x"].lost == 5
    assert watch.channels["x"].rate_hz == pytest.approx(10)


def test_a_new_run_starts_another_count() -> None:
    watch = Watch()
    for k in (500, 501, 503, 0, 1, 2):
        watch.receive(Received("x", twist_at(k), k))
    assert (watch.channels["x"].lost, watch.channels["x"].lost_since_restart) == (1, 0)
    assert watch.channels["x"].rate_hz == pytest.approx(10)
    assert watch.channels["x"].count == 6


def test_a_jump_of_the_numbers_is_a_new_numbering() -> None:
    watch = Watch()
    for k in (0, 1, 4, 2**40, 2**40 + 1):
        watch.receive(Received("x", encode(Twist(0.1, 0.2), 0, k), 0))
    assert (watch.channels["x"].lost, watch.channels["x"].lost_since_restart) == (2, 0)


def test_two_writers_in_turn_lose_nothing_and_have_a_rate() -> None:
    watch = Watch()
    for k in range(20):
        watch.receive(Received("x", encode(Twist(0.1, 0.2), 100_000 * k, 1000 * (k % 2) + k // 2), 0.1 * k))
    channel = watch.channels["x"]
    assert channel.lost == 0
    assert channel.rate_hz == pytest.approx(10)


def test_a_sender_that_does_not_number_has_a_rate() -> None:
    watch = Watch()
    for k in range(21):
        watch.receive(Received("x", encode(Twist(0.1, 0.2), 100_000 * k, 0), k))
    channel = watch.channels["x"]
    assert channel.rate_hz == pytest.approx(10)
    assert channel.published is not None
    assert channel.published.n == 21
    assert channel.lost == 0


def test_a_repeated_message_has_no_rate_of_stamps() -> None:
    watch = Watch()
    for k in range(5):
        watch.receive(Received("x", twist_at(3), k))
    channel = watch.channels["x"]
    assert (channel.rate_hz, channel.lost) == (None, 0)


def test_what_cannot_be_decoded_is_counted() -> None:
    watch = Watch()
    for data in (twist_at(0), twist_at(1)[:-1], b"", bytes(40), twist_at(2)):
        watch.receive(Received("x", data, 0))
    for data in (b"garbage", encode(SAID, 0, 0)[:-5]):
        watch.receive(Received(About.CHANNEL, data, 0))
    assert watch.channels["x"].undecodable == 3
    assert watch.channels["x"].count == 5
    assert watch.channels[About.CHANNEL].undecodable == 2


def test_one_message_has_no_rate() -> None:
    watch = Watch()
    watch.receive(Received("x", twist_at(3), 0))
    assert watch.channels["x"].rate_hz is None


def test_rates_are_those_of_the_last_ten_seconds() -> None:
    watch = Watch(lambda: 60.0)
    for k in range(400):  # 10 Hz for 20 s, then every 0.2 s for 40 s
        at_s = 0.1 * k if k < 200 else 20 + 0.2 * (k - 200)
        watch.receive(Received("x", twist_at(k), at_s))
    channel = watch.channels["x"]
    assert channel.wall_rate_hz == pytest.approx(5)
    assert channel.rate_hz == pytest.approx(10)
    assert channel.arriving is not None
    assert channel.arriving.n == pytest.approx(50, abs=1)
    assert channel.count == 400


def test_periods_leave_out_what_was_lost() -> None:
    watch = Watch()
    for k, period_us in ((0, 100_000), (1, 90_000), (2, 105_000), (5, 100_000), (6, 100_000)):
        watch.receive(Received("x", twist_at(k, period_us), k))
    periods = watch.channels["x"].published
    assert periods is not None
    steps = [0.09, 0.12, 0.1]
    assert periods.min_s == pytest.approx(min(steps))
    assert periods.max_s == pytest.approx(max(steps))
    assert periods.std_s == pytest.approx(np.std(steps))
    assert periods.n == 5
    assert periods.rate_hz == pytest.approx(10)


def test_a_channel_that_stops_is_silent_and_has_no_rate() -> None:
    now_s = 2.0
    watch = Watch(lambda: now_s)
    for k in range(21):
        watch.receive(Received("x", twist_at(k), 0.1 * k))
    channel = watch.channels["x"]
    assert not channel.is_silent
    assert channel.silent_s == pytest.approx(0)
    now_s = 5.2
    assert channel.is_silent
    assert channel.silent_s == pytest.approx(3.2)
    assert channel.rate_hz is None
    assert channel.wall_rate_hz is None
    text = as_text(watch, "heading", with_fields=False).plain
    assert text == "heading\nx  graphnav_lcm.twist_t, no new messages for 3.2 s, 40 B, 21 messages"
    watch.receive(Received("x", twist_at(21), 5.2))
    assert not channel.is_silent


def test_a_slow_channel_is_silent_after_three_of_its_periods() -> None:
    now_s = 22.9
    watch = Watch(lambda: now_s)
    for k in range(9):
        watch.receive(Received("x", twist_at(k), 2.0 * k))
    channel = watch.channels["x"]
    now_s = 21.9
    assert not channel.is_silent
    now_s = 22.1
    assert channel.is_silent


def test_a_name_stays_on_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "log") as writer:
        for k in range(2):
            writer.write(NASTY, 100_000 * k, twist_at(k))
    for words in (["spy"], ["hz"], ["bw"], ["hz", NASTY], ["bw", NASTY], ["echo", NASTY, "-n", "1"]):
        assert main([*words, str(tmp_path / "log")]) == 0
        assert capsys.readouterr().out.count(SHOWN) == 1
    assert main(["echo", "y\ny", str(tmp_path / "log")]) == 2
    error = f"{tmp_path / 'log'} has no channel 'y\\ny'\n  channels are {SHOWN}\n"
    assert capsys.readouterr().err == error


def test_the_rate_of_arrivals_stands_beside_that_of_the_stamps() -> None:
    watch = Watch()
    for k in range(5):
        watch.receive(Received("x", twist_at(k), 0.02 * k))
    said = as_text(watch, "", with_fields=False).plain
    assert said == "\nx  graphnav_lcm.twist_t, 10.00 Hz (arriving at 50.00 Hz), 40 B, 5 messages"


def test_a_run_has_ended_once_it_and_the_channel_are_silent() -> None:
    watch = Watch(lambda: 0.0)
    assert watch.ended_run("twist", 99.0) is None, "other programs may send at any time"
    watch.receive(Received(About.CHANNEL, encode(replace(SAID, run_id="run-a"), 0, 0), 1.0))
    watch.receive(Received("twist", twist_at(0), 2.0))
    assert watch.ended_run("twist", 2.0 + RUN_SILENT_S - 0.1) is None
    assert watch.ended_run("twist", 2.0 + RUN_SILENT_S) == "run-a"
    assert watch.ended_run("flow", 1.0 + RUN_SILENT_S) == "run-a"


def test_echo_ends_when_nothing_comes(group: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["echo", "twist", group, "-n", "1", "--timeout", "0.3"]) == 1
    assert capsys.readouterr().err.startswith(f"no message on {group} within 0.3 s\n")


def test_what_was_received_meanwhile_is_named() -> None:
    watch, feed = Watch(lambda: 0.0), Feed("udpm://239.255.76.67:7667?ttl=0")
    for k in range(14):
        watch.receive(Received(f"c{k:02d}", twist_at(k), 0.1 * k))
    said = str(watch.silence("twist", feed, 2.0)).splitlines()
    assert said == [
        f"no message on channel 'twist' of {feed.name} within 2 s",
        "  received: c00, c01, c02, c03, c04, c05, c06, c07, c08, c09, c10, c11 and 2 more",
    ]
