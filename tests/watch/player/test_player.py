"""Messages go out when they are due, by a clock that is set; keys pause, step and seek."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.errors import BusError
from graphnav.core.record import ChannelFilter, LogWriter, Recording
from graphnav.watch.log_cursor import LogCursor
from graphnav.watch.player import Player

LEFT, RIGHT = b"\x1b[D", b"\x1b[C"


class World:
    """A clock that passes only while the player waits or publishes, keys at their times, and what was published."""

    def __init__(self, keys: Sequence[tuple[float, bytes | None]] = (), takes_s: float = 0.0) -> None:
        self.now_s = 100.0
        self.sent: list[tuple[float, str]] = []
        self.notices: list[str] = []
        self._keys = [(100.0 + at_s, key) for at_s, key in keys]
        self._takes_s = takes_s

    def read(self, timeout_s: float) -> bytes | None:
        """Wait for a key."""
        if self._keys and self._keys[0][0] <= self.now_s + timeout_s:
            at_s, key = self._keys.pop(0)
            self.now_s = max(self.now_s, at_s)
            return key
        self.now_s += timeout_s
        return b""

    def send(self, channel: str, _data: bytes) -> None:
        """Note when a message was published."""
        self.sent.append((round(self.now_s - 100.0, 6), channel))
        self.now_s += self._takes_s

    def player(
        self, times_s: Sequence[float], speed: float = 1.0, size: int = 0, *, loop: bool = False, **options: Any
    ) -> Player:
        """Return a player of one message at each of the times, named by their places."""
        with tempfile.NamedTemporaryFile(suffix=".lcmlog") as file:
            with LogWriter(Path(file.name)) as writer:
                writer.write("before", 0, b"")
                for k, time_s in enumerate(times_s):
                    writer.write(str(k), round(1e6 * time_s), bytes(size))
            recording = Recording(file.name)
        names = ChannelFilter(["before"], invert=True)
        begin_us = round(1e6 * times_s[0])
        cursor = LogCursor(recording, names, begin_us, loop=loop, now_s=lambda: self.now_s)
        cursor.set_speed(speed)
        return Player(cursor, self.send, notice=self.notices.append, now_s=lambda: self.now_s, **options)


@pytest.mark.parametrize("speed", [0.5, 1.0, 3.0])
def test_messages_keep_their_distances(speed: float) -> None:
    world = World()
    player = world.player([0, 0.1, 0.1, 2.5], speed)
    player.play(world)
    assert world.sent == [(round(t / speed, 6), str(k)) for k, t in enumerate([0, 0.1, 0.1, 2.5])]
    assert (player.n_played, player.behind_s) == (4, 0)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(takes_s=st.floats(0, 0.009))
def test_delays_do_not_add_up(takes_s: float) -> None:
    world = World(takes_s=takes_s)
    world.player([0.01 * k for k in range(500)]).play(world)
    assert world.sent[-1][0] == pytest.approx(4.99, abs=0.011)


def test_what_cannot_keep_up_is_told_and_does_not_burst() -> None:
    world = World(takes_s=0.25)
    player = world.player([0.1 * k for k in range(60)])
    player.play(world)
    assert player.behind_s == pytest.approx(60 * 0.15, abs=0.7)
    assert [notice.split(":")[0] for notice in world.notices] == ["cannot keep up with 1x"] * len(world.notices)
    assert 3 <= len(world.notices) <= 6


def test_a_stall_is_not_made_up_for() -> None:
    world = World()

    def stalled(channel: str, data: bytes) -> None:
        world.send(channel, data)
        if channel == "2":
            world.now_s += 60

    player = world.player([0.1 * k for k in range(20)])
    player._send = stalled
    player.play(world)
    gaps = [later - earlier for (earlier, _), (later, _) in zip(world.sent[3:], world.sent[4:], strict=False)]
    assert gaps == pytest.approx([0.1] * len(gaps))


def test_space_pauses_and_goes_on() -> None:
    world = World([(0.25, b" "), (5.25, b" ")])
    world.player([0.1 * k for k in range(6)]).play(world)
    assert [at_s for at_s, _ in world.sent] == pytest.approx([0, 0.1, 0.2, 5.3, 5.4, 5.5])


def test_n_plays_all_of_the_next_stamp() -> None:
    world = World([(0.05, b"n"), (1, b"n"), (2, b"n"), (3, b"q")])
    world.player([0, 0.1, 0.1, 0.2, 0.3, 0.4]).play(world)
    assert world.sent == [(0, "0"), (0.05, "1"), (0.05, "2"), (1, "3"), (2, "4")]


def test_after_the_last_step_it_waits_for_keys() -> None:
    world = World([(0.05, b"n"), (1, LEFT), (2, b" ")])
    world.player([0, 0.1]).play(world)
    assert world.sent == [(0, "0"), (0.05, "1"), (2, "0"), (2.1, "1")]


def test_arrows_seek() -> None:
    world = World([(1.5, RIGHT), (3.5, LEFT), (4.2, b"q")])
    world.player([float(k) for k in range(20)]).play(world)
    assert world.sent == [
        (0, "0"),
        (1, "1"),
        (2, "7"),  # 6.5 s at 1.5 s
        (3, "8"),
        (4, "4"),  # 3.5 s at 3.5 s
    ]


def test_seeking_stays_within_the_log() -> None:
    world = World([(0.5, LEFT), (1.2, RIGHT)])
    world.player([0, 1.0, 2.0]).play(world)
    assert world.sent == [(0, "0"), (0.5, "0"), (1.2, "2")]


def test_seeking_while_paused_publishes_nothing() -> None:
    world = World([(0.5, b" "), (1, RIGHT), (2, b"n"), (3, b"q")])
    world.player([float(k) for k in range(20)]).play(world)
    assert world.sent == [(0, "0"), (2, "6")]


def test_plus_and_minus_change_the_speed() -> None:
    world = World([(1.5, b"+"), (2.5, b"-"), (2.5, b"-")])
    world.player([float(k) for k in range(6)]).play(world)
    assert [at_s for at_s, _ in world.sent] == [0, 1, 1.75, 2.25, 3.5, 5.5]


def test_a_keyboard_that_ends_ends_it() -> None:
    world = World([(0.5, None)])
    world.player([0, 1, 2]).play(world)
    assert world.sent == [(0, "0")]


def test_a_loop_restarts_at_the_end() -> None:
    world = World([(2.6, b"q")])
    world.player([0.5, 1.0, 1.5], loop=True).play(world)
    assert world.sent == [(at_s, str(k % 3)) for k, at_s in enumerate([0, 0.5, 1, 1, 1.5, 2, 2, 2.5])]


def test_a_loop_of_a_moment_does_not_flood() -> None:
    world = World([(1.05, b"q")])
    world.player([0.0], loop=True).play(world)
    assert len(world.sent) == 11


def test_large_messages_of_one_stamp_are_spread() -> None:
    world = World()
    world.player([0.0] * 8 + [0.1], size=40_000).play(world)
    at = [at_s for at_s, _ in world.sent]
    assert at == pytest.approx([0, 0, 0.002, 0.002, 0.004, 0.004, 0.006, 0.006, 0.1])


def test_what_lcm_refuses_is_counted() -> None:
    world = World()

    def refuse(channel: str, data: bytes) -> None:
        if channel == "1":
            raise BusError("cannot publish 0 bytes on '1': too long")
        world.send(channel, data)

    player = world.player([0, 1, 2])
    player._send = refuse
    player.play(world)
    assert (player.n_played, player.n_refused) == (2, 1)
    assert player.refusal == "cannot publish 0 bytes on '1': too long"


def test_it_is_shown_five_times_a_second() -> None:
    world, shown = World(), []
    world.player([0, 0.5, 10], show=lambda: shown.append(world.now_s)).play(world)
    assert 40 <= len(shown) <= 52
