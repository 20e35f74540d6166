"""A log is played, paused, stepped through and jumped in."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.record import LogWriter
from graphnav.watch.feed import Feed, LogFeed
from graphnav.watch.view import PageFeed
from graphnav.watch.view.content.state import newest_map

from .drive import messages


@pytest.fixture
def source(log: Path) -> Iterator[PageFeed]:
    """Return a log at its beginning; the test moves it, no thread does."""
    source = PageFeed(Feed(str(log)))
    yield source
    source.start()
    source.close()


def player(source: PageFeed) -> LogFeed:
    """Return the player of a log."""
    assert source.log is not None
    return source.log


def counts(source: PageFeed) -> dict[str, int]:
    return {name: channel.count for name, channel in source.state.watch.channels.items() if channel.count}


def stamp(source: PageFeed, channel: str) -> int:
    watched = source.state.watch.channels[channel]
    assert watched.kind is not None
    assert watched.newest is not None
    stamped = watched.kind.stamp(watched.newest.data)
    assert stamped is not None
    return stamped[0]


def test_a_log_knows_its_length(source: PageFeed) -> None:
    assert player(source).length_s == pytest.approx(3.9)
    assert player(source).recording.n_events > 200


@pytest.mark.parametrize("at_s", [0.0, 0.05, 1.0, 2.75, 3.9, 99.0])
def test_a_jump_shows_the_newest_before_it(source: PageFeed, at_s: float) -> None:
    player(source).seek(at_s)
    newest_us = min(int(at_s * 10), 39) * 100_000
    assert stamp(source, "robot.image") == newest_us
    assert counts(source)["robot.image"] == newest_us // 100_000 + 1
    assert player(source).at_s == pytest.approx(min(at_s, 3.9))


def test_a_jump_back_and_forth_changes_nothing(source: PageFeed) -> None:
    player(source).seek(2.0)
    before = counts(source)
    player(source).seek(0.3)
    player(source).seek(2.0)
    assert counts(source) == before


def test_steps_go_by_the_open_channel(source: PageFeed) -> None:
    player(source).seek(1.05)
    player(source).step(1, "robot.image")
    assert not player(source).is_playing
    assert stamp(source, "robot.image") == 1_100_000
    player(source).step(1, "graphnav.status")
    assert stamp(source, "graphnav.status") == 2_000_000
    player(source).step(-1, "robot.image")
    assert stamp(source, "robot.image") == 1_900_000
    player(source).step(-1, None)
    assert stamp(source, "robot.image") == 1_800_000


def test_steps_stop_at_the_ends(source: PageFeed) -> None:
    player(source).seek(0.0)
    player(source).step(-1, None)
    assert player(source).at_s == 0
    player(source).seek(3.9)
    player(source).step(1, None)
    assert player(source).at_s == pytest.approx(3.9)


def test_rates_and_losses_are_those_of_the_log(source: PageFeed) -> None:
    player(source).seek(3.9)
    channel = source.state.watch.channels["robot.image"]
    assert channel.rate_hz == pytest.approx(10)
    assert source.state.watch.channels["steer.steering"].lost == 7, "the first one is not counted as lost"


def test_a_jump_far_ahead_still_knows_the_path_and_the_map(tmp_path: Path, log: Path) -> None:
    path = tmp_path / "late.lcmlog"
    early = PageFeed(Feed(str(log)))
    early.start()
    early.close()
    with LogWriter(path) as writer:
        for channel, utime, data in messages():
            writer.write(channel, utime, data)
        writer.write("late", 60_000_000, b"the end")
    source = PageFeed(Feed(str(path)))
    player(source).seek(60)
    world, track = newest_map(source.state.channels_of(None).values()), source.state.track_of(None)
    assert world is not None
    assert world.channel == "robot.map"
    assert len(track.points_m) == 40
    assert counts(source)["robot.image"] == 1, "older pictures are not needed"
    source.start()
    source.close()


def test_playing_goes_on_from_a_jump_and_ends_paused(log: Path) -> None:
    source = PageFeed(Feed(str(log)))
    player(source).set_speed(5.0)
    with source.lock:
        player(source).seek(3.0)
    source.start()
    for _ in range(3000):
        with source.lock:
            if not player(source).is_playing:
                break
        player(source)._thread.join(0.01)
    assert player(source).at_s == pytest.approx(3.9)
    assert counts(source)["robot.image"] == 40
    with source.lock:
        player(source).play()
        assert player(source).at_s < player(source).length_s, "playing restarts at the end"
    source.close()


def test_stamps_that_run_backwards_are_played_in_the_order_of_the_file(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "odd.lcmlog") as writer:
        for utime in (5_000_000, 1_000_000, 6_000_000, 2_000_000):
            writer.write("x", utime, b"12345678")
    source = PageFeed(Feed(str(tmp_path / "odd.lcmlog")))
    assert player(source).length_s == 1
    player(source).seek(1.0)
    assert counts(source) == {"x": 4}
    source.start()
    source.close()


def test_damage_anywhere_is_told_and_a_damaged_stamp_does_not_stretch_the_log(tmp_path: Path, log: Path) -> None:
    data = bytearray(log.read_bytes())
    events = [found.start() for found in re.finditer(b"\\xed\\xa1\\xda\\x01", data)]
    data[events[20]] ^= 1
    data[events[40] + 12] ^= 0x40
    path = tmp_path / "spoiled.lcmlog"
    path.write_bytes(data[:-3])
    source = PageFeed(Feed(str(path)))
    source.start()
    source.close()
    assert player(source).length_s == pytest.approx(3.9, abs=0.2)
    told = source.damage.split("; ")
    assert [f"from byte {events[20]}" in told[0], "is truncated" in told[1]] == [True, True]
