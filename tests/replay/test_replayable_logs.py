"""A log that keeps what a replay needs: what it leaves out is made again, byte for byte, whatever else is swapped."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable
from io import StringIO
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.errors import UserError
from graphnav.core.machine.console import Console
from graphnav.core.messages import About
from graphnav.core.record import LogWriter
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.comparison.result_text import as_text

Record = Callable[..., Path]
Again = Callable[..., ReplayResult]
Rewrite = Callable[..., Path]
Events = list[tuple[str, int, bytes]]
LOOP = """
run: {until_s: 3, seed: 5}
stages:
  world:  {use: again.world, in: {command: fast.twist}}
  mean:   {use: again.mean, in: {image: world.image}}
  large:  {use: again.brighten, in: {image: world.image}}
  fast:   {use: again.mean, in: {image: large.image}}
  gather: {use: again.gather, in: {twist: mean.twist, odometry: world.noise}}
  score:  {use: again.mean, in: {image: world.truth}}
  watch:  {use: again.watch, in: {twist: mean.twist, image: world.truth}}
"""
SPARSE = LOOP.replace("again.world,", "again.world, with: {rate_hz: 100, image_steps: 7},")
PAIR = """
run: {until_s: 2, seed: 5}
stages:
  first:  {use: again.world, with: {rate_hz: 3}, in: {command: second_mean.twist}}
  robot:  {use: again.robot, in: {command: mean.twist}}
  second: {use: again.world, with: {rate_hz: 20, image_steps: 2}, in: {command: mean.twist}}
  mean:   {use: again.mean, in: {image: first.image}}
  second_mean: {use: again.mean, in: {image: second.truth}}
  score:  {use: again.mean, in: {image: first.truth}}
"""
REPLAYABLE = "run.record=replayable"


def events_of(log: Path) -> Events:
    """Return everything in a log but how it describes itself."""
    with Recording(log) as recording:
        return [(one.channel, one.utime, one.data) for one in recording.events() if one.channel != About.CHANNEL]


def large_of(events: Events) -> dict[str, list[int]]:
    """Return the stamps of the large messages by channel."""
    large = [(channel, utime) for channel, utime, data in events if len(data) >= Recording.SMALL_BYTES]
    return {name: [utime for channel, utime in large if channel == name] for name, _ in large}


def test_it_keeps_sources_except_what_they_make_again_and_small_messages(record: Record) -> None:
    full, kept = events_of(record(LOOP)), events_of(record(LOOP, REPLAYABLE, name="less"))
    large = large_of(full)
    assert {name: len(stamps) for name, stamps in large.items()} == {"world.truth": 31, "large.image": 31}
    assert large_of(kept) == {name: stamps[:1] for name, stamps in large.items()}
    assert [one for one in full if one in kept] == kept
    assert len(full) - len(kept) == 60
    images = LOOP.replace("again.world, in: {command: fast.twist}", "again.robot, with: {rows: 800}")
    images = images.replace("world.noise", "world.odometry").replace("world.truth", "world.image")
    large = large_of(events_of(record(images, REPLAYABLE, name="images")))
    assert {name: len(stamps) for name, stamps in large.items()} == {"world.image": 31, "large.image": 1}


@pytest.mark.parametrize("text", [LOOP, SPARSE, PAIR], ids=["loop", "sparse", "pair"])
def test_what_it_leaves_out_is_made_again(record: Record, again: Again, tmp_path: Path, text: str) -> None:
    full, log = record(text), record(text, REPLAYABLE, name="less")
    assert log.stat().st_size < full.stat().st_size / 4
    out = tmp_path / "out.lcmlog"
    result = again(log, out=out)
    assert result.is_equal, result.first
    assert result.unlike == ()
    assert sorted(events_of(out)) == sorted(events_of(full))
    assert result.scores == result.recorded_scores
    back = again(out)
    assert (back.is_equal, back.reproduced, back.lost) == (True, (), ())


def test_the_log_of_the_replay_is_in_the_order_of_the_run(record: Record, again: Again, tmp_path: Path) -> None:
    again(record(LOOP, REPLAYABLE, name="less"), out=tmp_path / "out.lcmlog")
    assert events_of(tmp_path / "out.lcmlog") == events_of(record(LOOP))


def test_sources_hear_the_recorded_commands_whatever_is_swapped(record: Record, again: Again, tmp_path: Path) -> None:
    out = tmp_path / "out.lcmlog"
    swaps = ("fast.gain=0.1", "mean=again.fails", "mean.at=-1", "mean.in.twist=fast.twist", "run.seed=9")
    of_world = ("world.rate_hz=7", "world.in.command=mean.twist")
    result = again(record(LOOP, REPLAYABLE, name="less"), *swaps, *of_world, out=out)
    assert result.first is not None
    assert result.first[0] == "fast.twist"
    assert result.channels["world.image"].is_equal
    full = events_of(record(LOOP))
    for channel in ("world.truth", "world.image", "world.noise"):
        assert [one for one in events_of(out) if one[0] == channel] == [one for one in full if one[0] == channel]


def test_a_source_is_stepped_again_only_for_what_is_wanted(record: Record, again: Again, tmp_path: Path) -> None:
    text = "\n".join(line for line in LOOP.splitlines() if "world.truth" not in line)
    log = record(text, REPLAYABLE)
    result = again(log)
    assert (result.reproduced, "world.image" in result.played, "world.image" in result.channels) == ((), True, False)
    result = again(log, out=tmp_path / "out.lcmlog")
    assert [(one.stage, one.channels, one.inputs) for one in result.reproduced] == [
        ("world", ("world.truth",), ("fast.twist",))
    ]
    result = again(log, "more+=again.mean", "more.in.image=world.truth")
    assert result.new == {"more.twist": 31}
    assert result.reproduced[0].checked == ("world.image", "world.noise")


def test_a_source_that_makes_something_else_is_reported(record: Record, again: Again, tmp_path: Path) -> None:
    log, other = record(LOOP, REPLAYABLE), tmp_path / "other.lcmlog"
    counts = Counter[str]()
    with Recording(log) as recording, LogWriter(other) as writer:
        for channel, utime, data in recording.events():
            is_changed = (channel, counts[channel]) == ("world.image", 7)
            counts[channel] += 1
            writer.write(channel, utime, data[:-1] + bytes([data[-1] ^ 1]) if is_changed else data)
    result = again(other)
    assert not result.is_equal
    assert result.first is not None
    assert (result.first[0], result.first[1].at_us) == ("world.image", 700_000)
    assert result.channels["large.image"].is_equal, "the recorded image is played, and of that only one is recorded"
    console = Console(file=StringIO(), width=200)
    console.print(as_text(result, console))
    assert isinstance(console.file, StringIO)
    lines = [line.strip() for line in console.file.getvalue().splitlines()]
    assert "reproduced: world.truth, by stepping world with the recorded fast.twist" in lines
    assert (
        "world.truth may not be as in the run: world does not make world.image as recorded; "
        "replay on the kind of machine and with the versions of the run's summary.json"
    ) in lines


def test_a_lost_command_ends_what_can_be_made_again(record: Record, again: Again, rewrite: Rewrite) -> None:
    log = rewrite(record(LOOP, REPLAYABLE), lambda channel, index: (channel, index) != ("fast.twist", 12))
    result = again(log)
    assert result.is_equal
    assert result.until_s == 1.1
    assert result.lost == (
        "replayed up to 1.10 s; later messages are missing: fast.twist: 1 of 31, the first after 1.10 s",
    )
    assert again(log, play=["score", "watch"]).until_s == 1.1


def test_a_cold_start_steps_sources_from_the_beginning(record: Record, again: Again, tmp_path: Path) -> None:
    full, log = record(LOOP), record(LOOP, REPLAYABLE, name="less")
    for text in (LOOP, SPARSE):
        full, log = (record(text, *sets, name=f"{len(text)}{len(sets)}") for sets in ((), (REPLAYABLE,)))
        outs = [tmp_path / f"{len(text)}-{name}.lcmlog" for name in ("full", "less")]
        for one, out in zip((full, log), outs, strict=True):
            again(one, from_s=1.03, is_cold=True, out=out)
        expected, found = map(events_of, outs)
        assert sorted(found) == sorted(expected)


def test_outputs_of_stages_are_played_from_a_full_log(record: Record, again: Again) -> None:
    log = record(LOOP, REPLAYABLE)
    with pytest.raises(UserError) as caught:
        again(log, play=["large"])
    assert str(caught.value) == (
        f"{log} is missing messages that fast read:\n"
        "  large.image: all but 1, the first after 0.00 s\n"
        f"  write the complete log: graphnav replay {log.parent} -o full.lcmlog, and replay that"
    )
    assert again(log, play=["mean"]).is_equal


def test_a_log_says_how_to_make_the_rest_again(record: Record) -> None:
    log = record(LOOP, REPLAYABLE)
    other = log.rename(log.parent / "other.lcmlog")
    with Recording(other) as recording:
        assert recording.completion_hint == f"write the complete log: graphnav replay {other} -o full.lcmlog"
    with Recording(other.rename(log)) as recording:
        assert recording.completion_hint == f"write the complete log: graphnav replay {log.parent} -o full.lcmlog"
    for option in ("all", "small"):
        with Recording(record(LOOP, f"run.record={option}", name=option)) as recording:
            assert recording.completion_hint == ""


def test_stamps_of_a_source_tell_its_tick_where_what_follows_is_left_out(record: Record, again: Again) -> None:
    text = """
    run: {until_s: 1, seed: 5}
    stages:
      world:  {use: again.world, with: {rate_hz: 100, image_steps: 4}}
      large:  {use: again.brighten, in: {image: world.image}}
      more:   {use: again.brighten, in: {image: large.image}}
      mean:   {use: again.mean, in: {image: more.image}}
      gather: {use: again.gather, in: {twist: mean.twist, odometry: world.noise}}
    """
    assert again(record(text)).is_equal
    log = record(text, REPLAYABLE, name="less")
    assert again(log).is_equal
    utimes = [utime for channel, utime, _ in events_of(log) if channel == "world.noise"]
    assert all(earlier < later for earlier, later in itertools.pairwise(utimes))
