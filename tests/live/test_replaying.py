"""The log of a live run says what each stage stepped with, so that it replays without a difference."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from graphnav import Odometry, Recording
from graphnav.catalog import Catalog
from graphnav.errors import UserError
from graphnav.live.firing import FIRED
from graphnav.messages import Fired
from graphnav.record import LogWriter
from graphnav.replay import ReplayOptions, ReplayResult, graph_to_replay, replay

if TYPE_CHECKING:
    from tests.live.conftest import Live, Outside

    Begin = Callable[..., Live]
    Program = Callable[..., Outside]

STAGES = Path(__file__).parent / "stages.py"
ALL = """
run: {until_s: 30, record: all}
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  base.odometry: {channel: ODOMETRY, type: graphnav_lcm.odometry_t}
stages:
  tick:   {use: probe.ticker, with: {rate_hz: 50}, in: {command: guard.twist}}
  see:    {use: probe.brightness, in: {image: camera.image}}
  slow:   {use: probe.brightness, with: {dawdle_s: 0.03}, in: {image: camera.image}}
  both:   {use: probe.both, in: {a: see.twist, b: slow.twist}}
  gather: {use: probe.gather, in: {image: camera.image, odometry: base.odometry}}
  guard:  {use: probe.pass, every_ms: 20, in: {command: both.twist, image: camera.image}}
outputs: {guard.twist: {channel: SPEED, motor: false}}
"""


@pytest.fixture
def log(live: Begin, outside: Program) -> Path:
    """Return the log of a run with timers, a source, joins and inputs that are read in all three ways."""
    program = outside("SPEED")
    run = live(ALL)
    program.wait_for(lambda: bool(program.of("SPEED")))
    for level in range(40):
        for _ in range(3):
            program.say("ODOMETRY", Odometry(x_m=0.1 * level, y_m=0.0, yaw_rad=0.0, v_mps=1.0, omega_radps=0.0))
        program.show("CAMERA", level)
        time.sleep(0.015)
    program.wait_for(lambda: any(v > 0 for _, v in program.speeds("SPEED")))
    run.stop()
    return run.folder / "run.lcmlog"


def _is_heard(program: Outside, speed: int) -> bool:
    return any(round(v) == speed for _, v in program.speeds("SPEED"))


def again(log: Path, *sets: str, **options: Any) -> ReplayResult:
    """Replay a log with swaps."""
    catalog = Catalog()
    catalog.add_file(STAGES)
    with Recording(log) as recording:
        return replay(recording, graph_to_replay(recording, catalog, sets=sets), ReplayOptions(**options))


def test_nothing_swapped_is_no_difference(log: Path) -> None:
    result = again(log)
    assert result.is_equal, result.first
    assert result.lost == ()
    assert set(result.stepped) == {"see", "slow", "both", "gather", "guard"}
    with Recording(log) as recording:
        counts = {name: recording.count(name) for name in result.channels}
        assert recording.count(FIRED) >= result.n_ticks
    assert {name: channel.n_compared for name, channel in result.channels.items()} == counts
    assert min(counts.values()) > 0


def test_a_swap_is_found_and_what_does_not_depend_on_it_is_equal(log: Path) -> None:
    result = again(log, "slow.fail_at=-1", "see=probe.trouble")
    assert result.first is not None
    assert result.first[0] == "see.twist"
    assert result.channels["slow.twist"].is_equal
    assert result.channels["gather.goal"].is_equal
    assert not result.channels["both.twist"].is_equal
    assert not result.channels["guard.twist"].is_equal


def test_the_middle_is_played_and_comparing_begins_later(log: Path) -> None:
    result = again(log, play=["both"])
    assert result.is_equal
    assert set(result.stepped) == {"gather", "guard"}
    whole = again(log)
    late = again(log, from_s=whole.until_s / 2)
    assert late.is_equal
    assert 0 < late.channels["guard.twist"].n_compared < whole.channels["guard.twist"].n_compared
    cold = again(log, from_s=whole.until_s / 2, is_cold=True)
    assert cold.n_ticks < whole.n_ticks


def test_a_stage_that_reads_something_new_is_refused(log: Path) -> None:
    with pytest.raises(UserError, match=r"stage 'both' reads 'slow\.twist' on 'a', as it did not in the live run"):
        again(log, "both.in.a=slow.twist")


def test_a_log_without_firings_is_refused(log: Path, tmp_path: Path) -> None:
    with Recording(log) as recording, LogWriter(tmp_path / "old.lcmlog") as writer:
        for event in recording.events():
            if event.channel != FIRED:
                writer.write(*event)
    with pytest.raises(
        UserError, match=r"old\.lcmlog does not say when each stage fired: it holds no 'graphnav\.fired'"
    ):
        again(tmp_path / "old.lcmlog")


def test_messages_that_the_log_lacks_are_told(log: Path, tmp_path: Path) -> None:
    seen = 0
    with Recording(log) as recording, LogWriter(tmp_path / "less.lcmlog") as writer:
        for event in recording.events():
            seen += event.channel == "camera.image"
            if event.channel != "camera.image" or seen != 5:
                writer.write(*event)
    with pytest.raises(
        UserError, match=r"less\.lcmlog lacks messages that its stages stepped with:\n  camera\.image: "
    ):
        again(tmp_path / "less.lcmlog")


def test_a_cut_log_is_replayed_up_to_the_cut(log: Path, tmp_path: Path) -> None:
    data = log.read_bytes()
    begin = data.index(bytes.fromhex("eda1da01"), len(data) * 2 // 3)
    (tmp_path / "cut.lcmlog").write_bytes(data[: begin + 5])
    result = again(tmp_path / "cut.lcmlog")
    assert result.is_equal, result.first
    assert result.lost
    assert result.n_ticks > 10


def test_a_small_log_keeps_the_firings(live: Begin, outside: Program) -> None:
    program = outside("SPEED")
    run = live(ALL.replace(", record: all", ""))
    program.wait_for(lambda: bool(program.of("SPEED")))
    for level in range(5):
        program.show("CAMERA", level, size=(80, 80))
        program.wait_for(partial(_is_heard, program, 2 * level))
    _, recording = run.stop()
    fired = [message for _, _, message in recording.messages(FIRED) if isinstance(message, Fired)]
    assert {one.stage for one in fired} >= {"see", "slow", "both", "guard", "tick"}
    with pytest.raises(UserError, match=r"camera\.image: \d of \d\n"):
        again(run.folder / "run.lcmlog")
