"""The replay of a live run writes a log that replays without a difference; stages may be added."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from graphnav import Recording, Twist
from graphnav.core.cli import main
from graphnav.core.messages import About, Fired
from graphnav.replay.comparison.result import ReplayResult

Again = Callable[..., ReplayResult]

TWIN = ("twin+=probe.brightness", "twin.in.image=camera.image")


def said_in(log: Path) -> dict[str, list[bytes]]:
    """Return the messages of each channel, without what the log says of itself."""
    said: dict[str, list[bytes]] = defaultdict(list)
    with Recording(log) as recording:
        for event in recording.events():
            said[event.channel].append(event.data)
    del said[About.CHANNEL]
    return said


def speeds(recording: Recording, channel: str) -> dict[int, float]:
    """Return what was published on a channel, by stamp."""
    return {utime: twist.v_mps for utime, _, twist in recording.messages(channel) if isinstance(twist, Twist)}


@pytest.mark.parametrize(
    ("sets", "options"),
    [
        ((), {}),
        ((), {"play": ["both"]}),
        ((), {"play": ["see.twist", "slow.twist"]}),
        (("see=probe.trouble",), {}),
        (TWIN, {}),
        ((*TWIN, "both.in.a=twin.twist"), {}),
        (("late+=probe.pass", "late.in.command=both.twist", "late.in.image=camera.image"), {}),
        (("more+=probe.gather", "more.in.image=camera.image", "more.in.odometry=base.odometry"), {}),
    ],
)
def test_the_log_of_a_replay_replays_without_a_difference(
    again: Again, log: Path, tmp_path: Path, sets: Sequence[str], options: dict[str, Any]
) -> None:
    out, twice = tmp_path / "out.lcmlog", tmp_path / "twice.lcmlog"
    first = again(log, *sets, out=out, **options)
    second = again(out, out=twice)
    assert second.is_equal, second.first
    assert (second.lost, second.new, second.not_replayed) == ((), {}, ())
    assert set(second.stepped) >= set(first.stepped)
    with Recording(out) as recording:
        for name, channel in second.channels.items():
            assert channel.n_compared == recording.count(name) > 0, name
            assert (channel.n_not_recorded, channel.n_extra, channel.n_missing) == (0, 0, 0), name
    assert said_in(twice) == said_in(out)


def test_the_log_of_a_replay_that_begins_later_begins_there(again: Again, log: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.lcmlog"
    begin_s = again(log).until_s / 2
    first = again(log, out=out, from_s=begin_s, is_cold=True)
    second = again(out)
    assert second.is_equal, second.first
    assert second.n_ticks == first.n_ticks > 0


def test_the_log_of_a_replay_describes_itself(
    again: Again, log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.lcmlog"
    again(log, *TWIN, out=out)
    with Recording(out) as recording, Recording(log) as recorded:
        assert recording.at(0).channel == About.CHANNEL
        assert "twin" in recording.graph["stages"]
        assert recording.begin_us == recorded.begin_us
        assert recording.timeline.n_jumps == 0
        for name in ("camera.image", "base.odometry", "tick.goal"):
            assert [e.data for e in recording.events() if e.channel == name] == [
                e.data for e in recorded.events() if e.channel == name
            ]
    assert main(["info", str(out)]) == 0
    assert "no damage" in capsys.readouterr().out


def test_an_added_stage_fires_when_its_inputs_are_complete(again: Again, log: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.lcmlog"
    result = again(log, *TWIN, "sum+=probe.both", "sum.in.a=twin.twist", "sum.in.b=see.twist", out=out)
    assert result.is_equal, "what the run had is as recorded"
    with Recording(log) as recording:
        n_images = recording.count("camera.image")
    assert result.new["twin.twist"] == n_images
    with Recording(out) as recording:
        twin = speeds(recording, "twin.twist")
        see = speeds(recording, "see.twist")
        sums = speeds(recording, "sum.twist")
        fired = [m for _, _, m in recording.messages("graphnav.fired") if isinstance(m, Fired) and m.stage == "sum"]
    assert twin.items() >= see.items(), "the run overtook what the replay does not"
    assert sums.keys() == see.keys()
    assert len(fired) == result.new["sum.twist"] == len(see)


def test_an_added_stage_with_a_timer_fires_on_it(again: Again, log: Path) -> None:
    wires = ("late.in.command=both.twist", "late.in.image=camera.image")
    timed = again(log, "late+=probe.pass", *wires, "late.every_ms=10")
    bare = again(log, "late+=probe.pass", *wires)
    assert timed.new["late.twist"] >= int(100 * timed.until_s) - 1 > bare.new["late.twist"]


def test_what_reads_an_equal_stage_instead_has_no_differences(again: Again, log: Path) -> None:
    result = again(log, *TWIN, "both.in.a=twin.twist")
    assert result.is_equal, result.first
    assert result.channels["both.twist"].n_compared > 0
    other = again(log, "both.in.a=slow.twist")
    assert other.is_equal, "slow publishes what see publishes"
    differs = again(log, "dark+=probe.trouble", "dark.in.image=camera.image", "both.in.a=dark.twist")
    assert not differs.channels["both.twist"].is_equal
    assert not differs.channels["guard.twist"].is_equal
    assert differs.channels["see.twist"].is_equal


def test_an_added_stage_that_fails_says_when(again: Again, log: Path) -> None:
    result = again(log, *TWIN, "twin.fail_at=3")
    said, at = result.failure.splitlines()
    assert re.fullmatch(r"stage 'twin' \(probe\.brightness\) failed at \d\.\d\d s: told to fail", said)
    assert re.fullmatch(r"  ValueError at stages\.py:\d+ in step", at)
