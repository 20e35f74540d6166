"""A cursor hands out the events of a log once, when its clock reaches them, and moves as it is told."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav.core.record import ChannelFilter, LogWriter, Recording
from graphnav.watch.log_cursor import LogCursor

EVENTS = [("a", 0.0), ("b", 0.0), ("a", 0.1), ("b", 0.15), ("a", 0.2), ("a", 0.3), ("b", 0.3)]


class Time:
    """A clock that the test moves."""

    now_s = 50.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("cursor") / "log"
    with LogWriter(path) as writer:
        for name, at_s in EVENTS:
            writer.write(name, 7_000_000 + round(at_s * 1e6), b"")
    return Recording(path)


def test_events_are_handed_out_once_when_they_are_due(recording: Recording) -> None:
    now = Time()
    cursor = LogCursor(recording, now_s=now)
    assert list(cursor.due()) == [0, 1]
    assert cursor.wait_s() == pytest.approx(0.1)
    now.now_s += 0.16
    assert list(cursor.due(1)) == [2]
    assert list(cursor.due()) == [3]
    cursor.set_speed(0.5)
    assert cursor.wait_s() == pytest.approx(0.08)
    cursor.pause()
    now.now_s += 60
    assert not cursor.due()
    cursor.resume()
    now.now_s += 60
    assert list(cursor.due()) == [4, 5, 6]
    assert cursor.has_ended
    assert cursor.at_us == 300_000


def test_channels_and_times_are_selected(recording: Recording) -> None:
    cursor = LogCursor(recording, ChannelFilter(["a"]), 100_000, 200_000, now_s=Time())
    cursor.set_clock(cursor.end_us)
    assert (len(cursor), cursor.channels) == (2, frozenset({"a"}))
    assert list(cursor.due()) == [2, 4]
    assert len(LogCursor(recording, ChannelFilter(["c"]))) == 0


def test_a_loop_begins_again(recording: Recording) -> None:
    now = Time()
    cursor = LogCursor(recording, ChannelFilter(["b"]), loop=True, now_s=now)
    now.now_s += 0.3
    assert list(cursor.due()) == [1, 3, 6]
    assert list(cursor.due()) == [1]
    assert not cursor.has_ended


def test_steps_go_by_the_messages_of_a_channel(recording: Recording) -> None:
    cursor = LogCursor(recording, now_s=Time())
    cursor.pause()
    cursor.due()
    assert not cursor.step(2, "a")
    assert list(cursor.due()) == [2, 3, 4]
    assert list(cursor.newest("b")) == [3]
    assert cursor.step(-1, "a")
    assert cursor.at_us == 100_000
    assert list(cursor.due()) == [2]
    assert cursor.step(-9)
    assert (cursor.at_us, list(cursor.due())) == (0, [0, 1])
    assert not cursor.step(-1)
    cursor.step(99)
    assert cursor.at_us == 300_000


def test_a_viewer_gets_the_newest_of_each_channel_and_the_track(recording: Recording) -> None:
    cursor = LogCursor(recording, now_s=Time())
    cursor.seek(250_000)
    assert cursor.earlier(lambda name: name == "a") == ({3, 4}, {0, 2})
    assert cursor.earlier(lambda _: False, 2) == ({0, 1}, set())
    assert list(cursor.newest_since(100_000, 2)) == [3, 4]


@settings(derandomize=True, deadline=None, max_examples=50)
@given(moves=st.lists(st.tuples(st.sampled_from(["seek", "step", "wait"]), st.integers(-3, 3)), max_size=12))
def test_what_is_handed_out_is_what_lies_before_the_time(recording: Recording, moves: list[tuple[str, int]]) -> None:
    now = Time()
    cursor = LogCursor(recording, now_s=now)
    for how, amount in moves:
        if how == "seek":
            cursor.seek(100_000 * amount)
        elif how == "step":
            cursor.step(amount or 1)
        else:
            now.now_s += 0.05 * abs(amount)
        cursor.due()
        handed_out = [number for number in range(len(EVENTS)) if cursor.time_us(number) <= round(cursor.at_us)]
        assert list(cursor.newest_since(0, 99)) == handed_out
