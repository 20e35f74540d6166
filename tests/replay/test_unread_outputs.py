"""Outputs that nothing reads, in the recorded run or in its replay."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.errors import UserError
from graphnav.replay.comparison.result import ReplayResult

Record = Callable[..., Path]
Again = Callable[..., ReplayResult]
SPARE = """
run: {until_s: 1, seed: 5}
stages:
  robot: {use: again.spare}
  step:  {use: again.spare_step, in: {twist: robot.twist}}
  score: {use: again.score, in: {twist: step.twist}}
"""
MORE = "more+=again.score"


def test_a_new_stage_has_nothing_to_read_of_what_was_left_out(record: Record, again: Again) -> None:
    log = record(SPARE)
    with pytest.raises(UserError) as caught:
        again(log, MORE, "more.in.twist=robot.extra")
    assert str(caught.value) == (
        f"{log} is missing messages that more read:\n"
        "  robot.extra: all of them, because nothing read it in the recorded run\n"
        "  run the graph again with more"
    )


def test_what_was_recorded_is_compared_even_if_nothing_reads_it_now(
    record: Record, again: Again, tmp_path: Path
) -> None:
    log = record(SPARE, MORE, "more.in.twist=step.extra")
    without = tmp_path / "without.yaml"
    without.write_text(SPARE)
    result = again(log, graph=without)
    assert result.is_equal
    assert result.channels["step.extra"].n_compared == 11


def test_a_played_reader_is_a_reader(record: Record, again: Again) -> None:
    log = record(f"{SPARE}  late: {{use: again.late, in: {{twist: step.extra}}}}\n")
    result = again(log, play=["late"])
    assert "late" not in result.stepped
    assert result.channels["step.extra"].n_compared == 11
