"""Messages that wait for a link: all in order while it takes them, else the newest of a channel, in bounded memory."""

from __future__ import annotations

import math
import random
from collections import defaultdict

import pytest

from graphnav.processes.tunnel import outbox as module
from graphnav.processes.tunnel.outbox import OTHERS, Accounts, Outbox


@pytest.fixture
def outbox() -> Outbox:
    """Return an empty one."""
    return Outbox(Accounts())


def put(outbox: Outbox, channel: str, number: int, now_s: float, limit_hz: float = math.inf, size: int = 8) -> None:
    """Add a numbered message."""
    outbox.put(channel, number.to_bytes(8, "big") + bytes(size - 8), limit_hz, now_s)


def taken(outbox: Outbox, now_s: float) -> list[tuple[str, int]]:
    """Take everything; return channels and numbers."""
    found = []
    while outbox.has_more:
        channels, messages = outbox.take(now_s)
        assert channels
        found += [(name, int.from_bytes(data[:8], "big")) for name, data in zip(channels, messages, strict=True)]
    return found


def lost(outbox: Outbox, channel: str) -> tuple[int, int]:
    """Return how many messages of a channel were dropped and thinned."""
    account = outbox._accounts.of(channel)
    return account.dropped, account.thinned


def test_a_burst_leaves_complete_and_in_order(outbox: Outbox) -> None:
    for k in range(5000):
        put(outbox, "A", k, 0.0)
        put(outbox, "B", k, 0.0)
    found = taken(outbox, 0.1)
    assert [number for name, number in found if name == "A"] == list(range(5000))
    assert [number for name, number in found if name == "B"] == list(range(5000))
    assert outbox.n_bytes == outbox.n_messages == 0


def test_a_frame_is_small_unless_a_message_is_large(outbox: Outbox) -> None:
    for k in range(100):
        put(outbox, "SMALL", k, 0.0, size=10_000)
    put(outbox, "LARGE", 0, 0.0, size=900_000)
    while outbox.has_more:
        _, messages = outbox.take(0.0)
        assert sum(map(len, messages)) <= 65_536 or len(messages) == 1


def test_of_what_waits_too_long_the_newest_is_sent(outbox: Outbox) -> None:
    for k in range(30):
        put(outbox, "IMAGE", k, 0.1 * k)
    put(outbox, "ONCE", 0, 0.0)
    found = taken(outbox, 10.0)
    assert found == [("IMAGE", 29), ("ONCE", 0)]
    assert lost(outbox, "IMAGE") == (29, 0)
    assert lost(outbox, "ONCE") == (0, 0)


def test_channels_take_turns(outbox: Outbox) -> None:
    for k in range(3):
        put(outbox, "MANY", k, 0.0)
    put(outbox, "ONE", 0, 0.0)
    assert taken(outbox, 0.0) == [("MANY", 0), ("ONE", 0), ("MANY", 1), ("MANY", 2)]


def test_a_rate_keeps_the_newest_and_sends_it_when_it_is_due(outbox: Outbox) -> None:
    sent: list[int] = []
    for k in range(106):  # at 100 Hz
        now_s = k / 100
        put(outbox, "A", k, now_s, limit_hz=10.0)
        due_s = outbox.release(now_s)
        assert due_s == math.inf or now_s < due_s <= now_s + 0.1
        sent += [number for _, number in taken(outbox, now_s)]
    assert 10 <= len(sent) <= 12
    assert sent == sorted(sent)
    assert outbox.release(2.0) == math.inf
    assert taken(outbox, 2.0) == [("A", 105)]  # the last one is not lost
    account = outbox._accounts.of("A")
    assert account.passed + account.thinned == 106


def test_a_channel_below_its_rate_is_not_thinned(outbox: Outbox) -> None:
    found = []
    for k in range(20):
        put(outbox, "A", k, float(k), limit_hz=2.0)
        found += taken(outbox, float(k))
    assert found == [("A", k) for k in range(20)]


def test_memory_is_bounded_whatever_is_put(outbox: Outbox) -> None:
    for k in range(100):
        put(outbox, f"LARGE.{k}", k, 0.0, size=1 << 20)
        put(outbox, f"LIMITED.{k}", k, 0.0, limit_hz=1.0, size=1 << 20)
        put(outbox, f"LIMITED.{k}", k, 0.0, limit_hz=1.0, size=1 << 20)
    assert outbox.n_bytes <= 32 << 20
    outbox.drop_all()
    for k in range(50_000):
        put(outbox, "SMALL", k, 0.0)
    assert outbox.n_messages == 20_000
    assert taken(outbox, 0.0)[-1] == ("SMALL", 49_999)
    for k in range(3000):
        put(outbox, f"NAME.{k}", k, 0.0)
    assert len(outbox._pending) == 1000
    assert len(outbox._accounts.channels) == 1001
    assert outbox._accounts.of("ANOTHER") is outbox._accounts.of(OTHERS)
    assert len(taken(outbox, 0.0)) == 1000
    put(outbox, "NEW", 1, 1.0)  # there is room again
    assert taken(outbox, 1.0) == [("NEW", 1)]


@pytest.mark.parametrize("seed", range(20))
def test_nothing_is_lost_uncounted_or_out_of_order(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MAX_BYTES", 40_000)
    chance = random.Random(seed)
    outbox = Outbox(Accounts())
    now_s, n_put, found = 0.0, defaultdict[str, int](int), []
    for _ in range(3000):
        now_s += chance.expovariate(50.0)
        channel = chance.choice("ABCD")
        put(outbox, channel, n_put[channel], now_s, {"D": 5.0}.get(channel, math.inf), chance.choice((8, 5000)))
        n_put[channel] += 1
        outbox.release(now_s)
        if chance.random() < 0.1 and outbox.has_more:
            channels, messages = outbox.take(now_s)
            found += list(zip(channels, (int.from_bytes(data[:8], "big") for data in messages), strict=True))
    outbox.drop_all()
    for channel, n in n_put.items():
        numbers = [number for name, number in found if name == channel]
        account = outbox._accounts.of(channel)
        assert numbers == sorted(set(numbers))
        assert account.passed == len(numbers)
        assert account.passed + account.dropped + account.thinned == n
    assert outbox.n_bytes == outbox.n_messages == 0
