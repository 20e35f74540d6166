"""The account of a channel: its stamp and number, its delays, and when it is silent."""

from __future__ import annotations

from pathlib import Path

import graphnav_lcm
import pytest

from graphnav.core.codec import codec_of, encode
from graphnav.core.messages import Twist
from graphnav.core.record import silent_after_s
from graphnav.core.typeinfo import load_types
from graphnav.watch.channel_account import ChannelAccount, ChannelCounts, FirstArrivals, kind_of

TWIST = Twist(0.1, 0.2)


def test_stamp_and_number_are_read_where_types_have_them(tmp_path: Path) -> None:
    data = encode(TWIST, 77, 4711)
    kind = kind_of(data)
    assert kind is not None
    assert (kind.lcm_class, kind.is_stamped, kind.stamp(data)) == (graphnav_lcm.twist_t, True, (77, 4711))
    assert kind.stamp(data[:23]) is None
    assert kind_of(b"unknown type") is None
    (tmp_path / "late_t.lcm").write_text("package account_test; struct late_t { int32_t seq; int64_t utime; }\n")
    late = codec_of(load_types([str(tmp_path)])["account_test.late_t"]).encode({"seq": 3, "utime": 9})
    kind = kind_of(late)
    assert kind is not None
    assert (kind.is_stamped, kind.stamp(late), kind.stamp(late[:-1])) == (False, (9, 3), None)


def test_a_sender_is_silent_after_three_periods_and_at_least_a_second() -> None:
    assert silent_after_s(None) == silent_after_s(0.1) == 1.0
    assert silent_after_s(2.0) == 6.0
    assert silent_after_s(0.1, min_s=0.3) == pytest.approx(0.3)


def test_the_two_delays_are_told_apart() -> None:
    first = FirstArrivals()
    camera, command = ChannelAccount("camera", clock=lambda: 0.0), ChannelAccount("command", clock=lambda: 0.0)
    for k in range(5):
        for account, late_s in ((camera, 0.02), (command, 0.05)):
            at_s = 0.1 * k + late_s
            utime = account.receive(encode(TWIST, 100_000 * k, k), at_s)
            assert utime == 100_000 * k
            account.add_pipeline_delay(first.delay_s(utime, at_s))
    assert command.transport_age_s(0.0) == pytest.approx(0.05)
    assert camera.transport_age_s(0.0) == pytest.approx(0.02)
    assert command.pipeline_delay_s == pytest.approx(0.03)
    assert camera.pipeline_delay_s is None, "its messages are the first of their stamps"
    assert command.transport_age_s(3600.0) is None, "the stamps are of another clock"


def test_sizes_and_times_of_all_messages_are_counted() -> None:
    counts = ChannelCounts()
    assert counts.rate_hz is None
    for k, n_bytes in enumerate((30, 10, 20)):
        counts.add(n_bytes, 1.0 + 0.1 * k)
    assert (counts.count, counts.n_bytes, counts.min_bytes, counts.max_bytes, counts.last_bytes) == (3, 60, 10, 30, 20)
    assert counts.rate_hz == pytest.approx(10)
