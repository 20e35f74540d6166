"""A replay publishes what the run published; what is changed is found, with the first message that changed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.errors import UserError
from graphnav.core.messages import About
from graphnav.replay.comparison.field_differences import Tolerance
from graphnav.replay.comparison.result import ReplayResult

Record = Callable[..., Path]
Again = Callable[..., ReplayResult]
STEPPED = ("mean", "gather", "late", "score")


def events_of(log: Path) -> list[tuple[str, int, bytes]]:
    """Return everything in a log but how it describes itself."""
    with Recording(log) as recording:
        return [(one.channel, one.utime, one.data) for one in recording.events() if one.channel != About.CHANNEL]


def test_nothing_swapped_is_no_difference_byte_for_byte(record: Record, again: Again, tmp_path: Path) -> None:
    log = record()
    result = again(log, out=tmp_path / "again.lcmlog")
    assert result.is_equal
    assert result.stepped == STEPPED
    assert (result.n_ticks, result.until_s) == (31, 3.0)
    assert {name: channel.n_compared for name, channel in result.channels.items()} == {
        "mean.twist": 31,
        "gather.twist": 24,
        "late.motion": 24,
    }
    assert all(channel.is_equal for channel in result.channels.values())
    assert events_of(tmp_path / "again.lcmlog") == events_of(log)
    assert result.not_replayed == ()
    assert result.lost == ()


def test_the_log_of_a_replay_is_replayed(record: Record, again: Again, tmp_path: Path) -> None:
    again(record(), "mean.gain=0.25", out=tmp_path / "again.lcmlog")
    result = again(tmp_path / "again.lcmlog")
    assert result.is_equal
    assert result.channels["mean.twist"].n_compared == 31


def test_the_metrics_stand_beside_the_recorded_ones(record: Record, again: Again) -> None:
    log = record()
    result = again(log)
    assert result.scores.keys() == {"score"}
    assert result.scores == result.recorded_scores
    (log.parent / "other.lcmlog").write_bytes(log.read_bytes())
    assert again(log.parent / "other.lcmlog").recorded_scores == {}
    (log.parent / "summary.json").write_text("[1, ")
    assert again(log).recorded_scores == {}


def test_the_first_message_that_changed_is_found(record: Record, again: Again) -> None:
    result = again(record(), "mean.offset=0.5", "mean.since=7")
    assert not result.is_equal
    assert result.first is not None
    name, first = result.first
    assert (name, first.at_us, first.kind, first.field, first.where) == ("mean.twist", 700_000, "field", "v_mps", ())
    assert first.replayed == pytest.approx(first.recorded + 0.5)
    mean = result.channels["mean.twist"]
    assert (mean.n_compared, mean.n_differing, mean.n_missing, mean.n_extra) == (31, 24, 0, 0)
    assert mean.max_gap == pytest.approx(0.5)
    assert mean.fields.keys() == {"v_mps"}
    late = result.channels["late.motion"]
    assert late.first is not None
    assert late.first.at_us == 750_000, "gather is silent at the step that changed first"


def test_what_is_within_the_tolerance_is_equal(record: Record, again: Again) -> None:
    log = record()
    change = ("mean.offset=0.001",)
    assert not again(log, *change).is_equal
    assert not again(log, *change, tolerance=Tolerance(0.0009)).is_equal
    assert again(log, *change, tolerance=Tolerance(0.0011)).is_equal
    assert again(log, *change, tolerance=Tolerance(0.0, 0.01)).is_equal
    assert not again(log, *change, tolerance=Tolerance(0.0, 1e-9)).is_equal


def test_a_message_more_and_a_message_less_are_told(record: Record, again: Again, tmp_path: Path) -> None:
    always = tmp_path / "always.yaml"
    log = record()
    always.write_text(
        (tmp_path / "run.yaml").read_text().replace("{use: again.gather, in: {twist", "{use: again.fails, in: {twist")
        .replace(", odometry: robot.odometry, goal: robot.goal}", "}, with: {at: -1}")
    )  # fmt: skip
    result = again(log, graph=always)
    gather = result.channels["gather.twist"]
    assert (gather.n_compared, gather.n_extra, gather.n_missing) == (24, 7, 0)
    assert gather.first is not None
    back = record(always.read_text(), name="always_run")
    result = again(back, graph=tmp_path / "run.yaml")
    gather = result.channels["gather.twist"]
    assert (gather.n_compared, gather.n_extra, gather.n_missing) == (24, 0, 7)
    missing = result.channels["late.motion"]
    assert missing.n_missing == 7


def test_what_is_played_does_not_step(record: Record, again: Again, tmp_path: Path) -> None:
    log = record()
    result = again(log, "mean.offset=9", play=["mean.twist"], out=tmp_path / "again.lcmlog")
    assert result.is_equal
    assert result.stepped == ("gather", "late", "score")
    assert "mean.twist" not in result.channels
    assert events_of(tmp_path / "again.lcmlog") == events_of(log)


def test_what_is_then_not_needed_does_not_step_either(record: Record, again: Again, tmp_path: Path) -> None:
    text = """
    run: {until_s: 2, seed: 5}
    stages:
      robot:  {use: again.robot}
      mean:   {use: again.mean, in: {image: robot.image}}
      gather: {use: again.gather, in: {twist: mean.twist}}
      late:   {use: again.late, in: {twist: gather.twist}}
    """
    log = record(text)
    result = again(log, play=["gather"], out=tmp_path / "again.lcmlog")
    assert (result.stepped, result.not_needed) == (("late",), ("mean",))
    assert result.is_equal
    assert result.not_replayed == ("mean.twist",)
    back = again(tmp_path / "again.lcmlog")
    assert (back.stepped, back.is_equal) == (("mean", "gather", "late"), True)


def test_seeds_are_those_of_the_run(record: Record, again: Again, tmp_path: Path) -> None:
    log = record(name="run")
    other = tmp_path / "other_seed.yaml"
    other.write_text((tmp_path / "run.yaml").read_text().replace("seed: 5", "seed: 6"))
    assert again(log, graph=other).is_equal
    assert again(log, "run.seed=5").is_equal
    for words in ((log, "run.seed=6"),):
        mean = again(*words).channels["mean.twist"]
        assert mean.first is not None
        assert mean.first.at_us == 0
    assert not again(log, "run.seed=6", graph=other).is_equal


@pytest.mark.parametrize("is_cold", [False, True])
def test_comparing_from_a_time(record: Record, again: Again, *, is_cold: bool) -> None:
    log = record()
    result = again(log, from_s=1.25, is_cold=is_cold)
    mean = result.channels["mean.twist"]
    assert mean.n_compared == 18
    assert result.n_ticks == (18 if is_cold else 31)
    assert result.is_equal == (not is_cold)
    if is_cold:
        assert mean.first is not None
        assert mean.first.at_us == 1_300_000
        assert mean.fields["omega_radps"].first.replayed == 1.0


def test_a_cold_start_samples_what_was_there(record: Record, again: Again) -> None:
    log = record()
    cold = again(log, from_s=1.0, is_cold=True, tolerance=Tolerance(max_rel=2.0, max_abs=2.0))
    assert cold.channels["gather.twist"].fields.get("v_mps") is None, "the goal of 0.9 s is known at 1.0 s"


def test_the_log_of_a_cold_start_replays_without_a_difference(record: Record, again: Again, tmp_path: Path) -> None:
    out = tmp_path / "again.lcmlog"
    again(record(), out=out, from_s=1.0, is_cold=True)
    back = again(out)
    assert back.is_equal, back.first
    assert back.lost == ()
    assert back.channels["gather.twist"].n_compared == 16


def test_a_time_behind_the_end_is_refused(record: Record, again: Again) -> None:
    with pytest.raises(UserError, match=r"run\.lcmlog ends at 3\.00 s\n  --from 3\.5 is after the end"):
        again(record(), from_s=3.5)


def test_a_stage_that_fails_ends_the_replay(record: Record, again: Again) -> None:
    text = """
    run: {until_s: 2, seed: 5}
    stages:
      robot: {use: again.robot}
      mean:  {use: again.mean, in: {image: robot.image}}
      fails: {use: again.fails, with: {at: -1}, in: {twist: mean.twist}}
    """
    log = record(text)
    assert again(log).is_equal
    result = again(log, "fails.at=5")
    assert not result.is_equal
    assert (
        result.failure
        == "stage 'fails' (again.fails) failed at 0.40 s: worn out\n  ValueError at stages.py:223 in step"
    )
    assert result.first is None, "what was published before is equal, and what comes after was not tried"
    assert result.channels["mean.twist"].n_compared == 5


def test_a_run_that_ended_by_its_source_is_replayed_to_its_end(record: Record, again: Again) -> None:
    result = again(record(textwrap_loop("with: {last: 7}")))
    assert result.is_equal
    assert (result.n_ticks, result.until_s) == (8, 0.7)


def textwrap_loop(words: str) -> str:
    """Return the loop with words added to the robot."""
    return f"""
    run: {{seed: 5}}
    stages:
      robot:  {{use: again.robot, {words}, in: {{command: mean.twist}}}}
      mean:   {{use: again.mean, in: {{image: robot.image}}}}
    """


def test_two_sources_of_different_rates(record: Record, again: Again, tmp_path: Path) -> None:
    text = """
    run: {until_s: 2, seed: 5}
    stages:
      slow:   {use: again.robot, with: {rate_hz: 3}, in: {command: mean.twist}}
      fast:   {use: again.robot, with: {rate_hz: 10}}
      mean:   {use: again.mean, in: {image: fast.image}}
      gather: {use: again.gather, in: {twist: mean.twist, odometry: slow.odometry, goal: slow.goal}}
    """
    log = record(text)
    result = again(log, out=tmp_path / "again.lcmlog")
    assert result.is_equal
    assert sorted(events_of(tmp_path / "again.lcmlog")) == sorted(events_of(log))


def test_a_swap_says_what_is_no_longer_in_the_graph(record: Record, again: Again) -> None:
    result = again(record(), "gather=again.fails", "gather.at=-1")
    assert not result.is_equal
    assert result.channels["mean.twist"].is_equal


@pytest.mark.parametrize("sets", [("twin+=again.mean",), ("twin+=again.mean", "twin.gain=0.1")])
def test_a_stage_that_is_added_publishes_what_was_not_recorded(
    record: Record, again: Again, sets: tuple[str, ...]
) -> None:
    result = again(record(), *sets)
    assert "twin.twist" not in result.channels
    assert result.new == {"twin.twist": 31}
    assert result.is_equal
