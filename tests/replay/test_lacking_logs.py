"""A log that lacks what is needed is refused with what it lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graphnav import Image, Recording
from graphnav.core.codec import decode, encode
from graphnav.core.errors import UserError
from graphnav.core.messages import About
from graphnav.core.record import LogWriter
from graphnav.replay.comparison.result import ReplayResult

Record = Callable[..., Path]
Again = Callable[..., ReplayResult]
Rewrite = Callable[..., Path]
LARGE = """
run: {until_s: 2, seed: 5, record: small}
stages:
  robot:  {use: again.robot, with: {rows: 800}, in: {command: mean.twist}}
  mean:   {use: again.mean, in: {image: robot.image}}
  score:  {use: again.score, in: {twist: mean.twist}}
"""


def test_small_messages_only(record: Record, again: Again) -> None:
    log = record(LARGE)
    with pytest.raises(UserError) as caught:
        again(log)
    assert str(caught.value) == (
        f"{log} is missing messages that mean read:\n"
        "  robot.image: all but 1, the first after 0.00 s\n"
        "  record what a replay needs: --set run.record=replayable, 'graphnav run --tap full' for a logger; "
        "or play the outputs of these stages with --play"
    )
    result = again(log, play=["mean"])
    assert result.is_equal
    assert result.stepped == ("score",)


@pytest.mark.parametrize("cold_from_s", [0.0, 2.0])
def test_a_logger_that_missed_messages(record: Record, again: Again, rewrite: Rewrite, cold_from_s: float) -> None:
    log = rewrite(record(), lambda channel, index: channel != "robot.image" or index not in (4, 5, 9), offset_us=10**9)
    if cold_from_s:
        assert again(log, from_s=cold_from_s, is_cold=True).channels["mean.twist"].n_compared == 11
        return
    with pytest.raises(UserError, match=r"robot\.image: 3 of 31, the first after 0\.30 s"):
        again(log)


def test_a_channel_that_was_filtered_out(record: Record, again: Again, rewrite: Rewrite) -> None:
    log = record()
    with pytest.raises(UserError, match=r"robot\.image: all of them"):
        again(rewrite(log, lambda channel, _: channel != "robot.image", "one.lcmlog"))


def test_the_log_of_the_run_itself_is_used_up_to_what_is_missing(
    record: Record, again: Again, rewrite: Rewrite
) -> None:
    result = again(rewrite(record(), lambda channel, index: (channel, index) != ("robot.odometry", 2)))
    assert result.is_equal
    assert result.until_s == 0.1
    assert result.lost == (
        "replayed up to 0.17 s; later messages are missing: robot.odometry: 1 of 30, the first after 0.17 s",
    )


def test_a_logger_that_began_late(record: Record, again: Again, rewrite: Rewrite) -> None:
    log = rewrite(record(), lambda channel, index: channel == About.CHANNEL or index >= 3, offset_us=10**15)
    with pytest.raises(UserError, match=r"robot\.odometry: 3 of 30, from the first on"):
        again(log)


def test_outputs_that_are_not_in_the_log_are_no_difference(record: Record, again: Again, rewrite: Rewrite) -> None:
    log = rewrite(record(), lambda channel, index: channel != "mean.twist" or index % 3 == 0, offset_us=10**15)
    result = again(log)
    assert result.is_equal
    mean = result.channels["mean.twist"]
    assert (mean.n_compared, mean.n_extra, mean.n_not_recorded) == (11, 0, 20)
    without = rewrite(record(name="b"), lambda channel, _: channel != "mean.twist", "none.lcmlog", offset_us=10**15)
    assert again(without).channels["mean.twist"].n_not_recorded == 31


def test_the_log_of_a_logger_is_replayed(record: Record, again: Again, rewrite: Rewrite) -> None:
    result = again(rewrite(record(), lambda *_: True, offset_us=1_700_000_000_000_000))
    assert result.is_equal
    assert result.channels["mean.twist"].n_compared == 31


def test_a_log_of_two_runs_is_refused(record: Record, again: Again, tmp_path: Path) -> None:
    log = record()
    with Recording(log) as recording, LogWriter(tmp_path / "two.lcmlog") as writer:
        for at_us in (10**15, 2 * 10**15):
            for event in recording.events():
                writer.write(event.channel, at_us + event.utime, event.data)
    with pytest.raises(UserError, match=r"two\.lcmlog holds several runs: '.*' jumps back from 3\.00 s to 0\.00 s"):
        again(tmp_path / "two.lcmlog")


def test_pictures_that_the_tap_thinned(record: Record, again: Again, tmp_path: Path) -> None:
    log = record(LARGE.replace("small", "all").replace("800", "10000"))
    with Recording(log) as recording, LogWriter(tmp_path / "tap.lcmlog") as writer:
        for number, event in enumerate(recording.events()):
            data = event.data
            if event.channel == About.CHANNEL:
                data = encode(replace(decode(About, data)[2], run_id="12345678"), 0, 0)
            elif event.channel == "robot.image":
                utime, seq, image = decode(Image, data)
                data = encode(
                    replace(image, pixels=np.ascontiguousarray(image.pixels[::2, ::1]), step_px=2), utime, seq
                )
            writer.write(event.channel, 10**15 + number, data)
    with pytest.raises(UserError, match=r"'robot\.image' of .* was thinned by the tap: its step_px is 2"):
        again(tmp_path / "tap.lcmlog")


def test_a_log_that_does_not_say_its_graph(record: Record, again: Again, rewrite: Rewrite, tmp_path: Path) -> None:
    log = rewrite(record(), lambda channel, _: channel != About.CHANNEL)
    with pytest.raises(
        UserError, match=r"does not hold the graph that produced it: .*\n  name the graph with --graph FILE"
    ):
        again(log)
    assert again(log, graph=tmp_path / "run.yaml").is_equal


def test_a_channel_of_another_type(record: Record, again: Again, tmp_path: Path) -> None:
    log = record()
    other = tmp_path / "other.yaml"
    other.write_text(
        "run: {until_s: 3}\nchannels: {robot.odometry: robot.image, robot.image: robot.odometry}\n"
        "stages:\n  robot: {use: again.robot}\n  mean: {use: again.mean, in: {image: robot.image}}\n"
    )
    with pytest.raises(UserError, match=r"channel 'robot\.odometry' of .* is not Image, the type in the graph"):
        again(log, graph=other)


def test_an_empty_log(again: Again, tmp_path: Path) -> None:
    (tmp_path / "empty.lcmlog").touch()
    with pytest.raises(UserError, match="does not hold the graph that produced it"):
        again(tmp_path / "empty.lcmlog")
