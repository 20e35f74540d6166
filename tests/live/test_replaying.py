"""The log of a live run says what each stage stepped with, so that it replays without a difference."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from graphnav import Recording
from graphnav.core.errors import UserError
from graphnav.core.messages import Fired
from graphnav.core.record import LogWriter
from graphnav.replay.comparison.result import ReplayResult

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

    Again = Callable[..., ReplayResult]


def _is_heard(program: Outside, speed: int) -> bool:
    return any(round(v) == speed for _, v in program.speeds("SPEED"))


def test_nothing_swapped_is_no_difference(again: Again, log: Path) -> None:
    result = again(log)
    assert result.is_equal, result.first
    assert result.lost == ()
    assert set(result.stepped) == {"see", "slow", "both", "gather", "guard"}
    with Recording(log) as recording:
        counts = {name: recording.count(name) for name in result.channels}
        assert recording.count(Fired.CHANNEL) >= result.n_ticks
    assert {name: channel.n_compared for name, channel in result.channels.items()} == counts
    assert min(counts.values()) > 0


def test_a_swap_is_found_and_what_does_not_depend_on_it_is_equal(again: Again, log: Path) -> None:
    result = again(log, "slow.fail_at=-1", "see=probe.trouble")
    assert result.first is not None
    assert result.first[0] == "see.twist"
    assert result.channels["slow.twist"].is_equal
    assert result.channels["gather.goal"].is_equal
    assert not result.channels["both.twist"].is_equal
    assert not result.channels["guard.twist"].is_equal


def test_the_middle_is_played_and_comparing_begins_later(again: Again, log: Path) -> None:
    result = again(log, play=["both"])
    assert result.is_equal
    assert set(result.stepped) == {"gather", "guard"}
    complete = again(log)
    late = again(log, from_s=complete.until_s / 2)
    assert late.is_equal
    assert 0 < late.channels["guard.twist"].n_compared < complete.channels["guard.twist"].n_compared
    cold = again(log, from_s=complete.until_s / 2, is_cold=True)
    assert cold.n_ticks < complete.n_ticks


def test_a_log_without_firings_is_refused(again: Again, log: Path, tmp_path: Path) -> None:
    with Recording(log) as recording, LogWriter(tmp_path / "old.lcmlog") as writer:
        for event in recording.events():
            if event.channel != Fired.CHANNEL:
                writer.write(*event)
    with pytest.raises(UserError, match=r"old\.lcmlog does not hold the firings of the stages: no 'graphnav\.fired'"):
        again(tmp_path / "old.lcmlog")


def test_messages_that_the_log_lacks_are_told(again: Again, log: Path, tmp_path: Path) -> None:
    seen = 0
    with Recording(log) as recording, LogWriter(tmp_path / "less.lcmlog") as writer:
        for event in recording.events():
            seen += event.channel == "camera.image"
            if event.channel != "camera.image" or seen != 5:
                writer.write(*event)
    with pytest.raises(
        UserError, match=r"less\.lcmlog is missing messages that its stages stepped with:\n  camera\.image: "
    ):
        again(tmp_path / "less.lcmlog")


def test_a_cut_log_is_replayed_up_to_the_cut(again: Again, log: Path, tmp_path: Path) -> None:
    data = log.read_bytes()
    begin = data.index(bytes.fromhex("eda1da01"), len(data) * 2 // 3)
    (tmp_path / "cut.lcmlog").write_bytes(data[: begin + 5])
    result = again(tmp_path / "cut.lcmlog")
    assert result.is_equal, result.first
    assert result.lost
    assert result.n_ticks > 10


def test_a_small_log_keeps_the_firings(again: Again, every_kind: str, live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(every_kind.replace(", record: all", ""))
    program.wait_for(lambda: bool(program.of("SPEED")))
    for level in range(5):
        program.show("CAMERA", level, size=(80, 80))
        program.wait_for(partial(_is_heard, program, 2 * level))
    _, recording = run.stop()
    fired = [message for _, _, message in recording.messages(Fired.CHANNEL) if isinstance(message, Fired)]
    assert {one.stage for one in fired} >= {"see", "slow", "both", "guard", "tick"}
    with pytest.raises(UserError, match=r"camera\.image: \d of \d\n"):
        again(run.folder / "run.lcmlog")
    with pytest.raises(UserError, match=r"record what a replay needs: --set run\.record=replayable"):
        again(run.folder / "run.lcmlog")
    made = ["see", "slow", "both", "gather", "guard"]
    twin = ("twin+=probe.brightness", "twin.in.image=camera.image")
    with pytest.raises(UserError, match=r"is missing messages that twin read:\n  camera\.image: all but 1\n"):
        again(run.folder / "run.lcmlog", *twin, play=made)


def test_a_replayable_log_keeps_what_comes_in(again: Again, every_kind: str, live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(every_kind.replace("record: all", "record: replayable"))
    program.wait_for(lambda: bool(program.of("SPEED")))
    for level in range(5):
        program.show("CAMERA", level, size=(80, 80))
        program.wait_for(partial(_is_heard, program, 2 * level))
    _, recording = run.stop()
    assert recording.count("camera.image") > 1, "a small log has the first one"
    result = again(run.folder / "run.lcmlog", "twin+=probe.brightness", "twin.in.image=camera.image")
    assert result.is_equal, result.first
    assert result.reproduced == ()
    assert result.new["twin.twist"] > 1
    with Recording(run.folder / "run.lcmlog") as log:
        counts = {name: log.count(name) for name in result.channels}
    assert {name: channel.n_compared for name, channel in result.channels.items()} == counts
