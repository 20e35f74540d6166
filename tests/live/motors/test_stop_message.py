"""Stops follow the commands of their channel: stamps and sequence numbers go on."""

from __future__ import annotations

import time

import pytest

from graphnav.core.codec import decode, encode
from graphnav.core.messages import Twist
from graphnav.live.motors.channel import MotorChannel
from graphnav.live.motors.stop_message import StopMessage

STOP = encode(Twist(0.0, 0.0), 0, 0)


def message_of(stamp_at: int | None = 8, seq_at: int | None = 16) -> StopMessage:
    return StopMessage(MotorChannel("M", STOP, stamp_at, seq_at, 0.3))


def test_a_stop_before_any_command_has_the_wall_clocks_stamp() -> None:
    before_us = time.time_ns() // 1000
    utime, seq, twist = decode(Twist, message_of().stop(5.0))
    assert before_us <= utime <= time.time_ns() // 1000
    assert seq == 0
    assert (twist.v_mps, twist.omega_radps) == (0.0, 0.0)


def test_a_stop_has_the_stamp_of_now_by_the_clock_of_the_commands() -> None:
    message = message_of()
    message.forward(encode(Twist(0.1, 0.2), 3_000_000, 7), 10.0)
    assert [decode(Twist, message.stop(now_s))[:2] for now_s in (10.5, 10.52)] == [(3_500_000, 8), (3_520_000, 9)]


def test_commands_and_stops_are_counted_together() -> None:
    message, seqs = message_of(), list[int]()
    for k in range(3):
        seqs.append(decode(Twist, message.forward(encode(Twist(0.1, 0.2), k, k), k))[1])
    seqs += [decode(Twist, message.stop(4.0))[1] for _ in range(4)]
    for k in range(3, 5):
        seqs.append(decode(Twist, message.forward(encode(Twist(0.1, 0.2), k, k), k))[1])
    seqs.append(decode(Twist, message.stop(6.0))[1])
    assert seqs == list(range(10))


def test_a_command_is_forwarded_byte_by_byte_but_for_its_number_after_a_stop() -> None:
    message, data = message_of(), encode(Twist(0.1, 0.2), 5, 6)
    assert message.forward(data, 1.0) is data
    message.stop(2.0)
    assert message.forward(data, 3.0) == encode(Twist(0.1, 0.2), 5, 7)


def test_a_type_without_stamp_and_number_is_left_alone() -> None:
    message, data = message_of(None, None), encode(Twist(0.1, 0.2), 5, 6)
    assert message.forward(data, 1.0) is data
    assert message.stop(2.0) == STOP
    assert message.forward(data, 3.0) is data


@pytest.mark.parametrize("data", [b"", b"12345678", bytes(15), bytes(23)])
def test_a_command_that_is_too_short_for_its_type_harms_nothing(data: bytes) -> None:
    message = message_of()
    message.stop(0.5)
    assert message.forward(data, 1.0) == data
    assert len(message.stop(2.0)) == len(STOP)


def test_numbers_at_the_end_of_their_range_harm_nothing() -> None:
    message = message_of()
    message.forward(encode(Twist(0.1, 0.2), 2**63 - 1, 2**63 - 1), 1.0)
    assert decode(Twist, message.stop(2.0))[1] == -(2**63)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"max_age_s": 0.0}, "max_age_s is 0.0"),
        ({"max_age_s": float("nan")}, "max_age_s is nan"),
        ({"max_age_s": float("inf")}, "max_age_s is inf"),
        ({"stamp_at": 40}, "stamp_at is 40, the stop has 40 bytes"),
        ({"seq_at": -1}, "seq_at is -1"),
    ],
)
def test_a_channel_that_cannot_be_stopped_is_refused(changes: dict[str, float], what: str) -> None:
    arguments = {"name": "M", "stop": STOP, "stamp_at": 8, "seq_at": 16, "max_age_s": 0.3} | changes
    with pytest.raises(ValueError, match=what):
        MotorChannel(**arguments)  # type: ignore[arg-type]
