"""Which runs are begun first, and how long those left take."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import pytest

from graphnav import Recording
from graphnav.core.machine import Console
from graphnav.core.run_folder import RunFolder
from graphnav.studies.ablation.execution import RunTimes, TimeEstimate
from graphnav.studies.ablation.execution.run_times import longest_first
from graphnav.studies.ablation.plan import Case, Job
from graphnav.studies.ablation.results import expected_failures
from graphnav.studies.api import study_run as api
from graphnav.studies.commands import study_run as commands

CASE = Case(
    graph="hall",
    source="hall",
    variant="a",
    labels={},
    overrides=(),
    is_base=True,
    role="method",
    folder="runs/hall/a",
    same_as="",
    uses={},
    swapped=(),
    notices=(),
    graph_yaml="",
)
OTHER = replace(CASE, variant="b", folder="runs/hall/b")
LONG = replace(CASE, graph="laps", source="laps", folder="runs/laps/a")


def test_of_each_seed_the_graphs_with_the_longest_limits_come_first() -> None:
    jobs = [Job(case, seed) for seed in (7, 3) for case in (CASE, OTHER, LONG)]
    limits = {"hall": 60.0, "laps": 600.0}
    found = longest_first(jobs, lambda job: limits[job.case.source])
    assert [(job.seed, job.case) for job in found] == [(seed, case) for seed in (7, 3) for case in (LONG, CASE, OTHER)]
    without = longest_first(jobs, lambda job: None if job.case is OTHER else limits[job.case.source])
    assert [job.case for job in without[:3]] == [CASE, OTHER, LONG], "one without a limit may be the longest"


LIMITS = {"hall": 60.0, "laps": 600.0}


def times_of(*made: tuple[Case, float]) -> RunTimes:
    """Return what is known of runs: their cases, and how long each took."""
    times = RunTimes(lambda job: LIMITS[job.case.source])
    for seed, (case, took_s) in enumerate(made):
        times.add(Job(case, seed), took_s)
    return times


def test_one_run_tells_nothing_yet() -> None:
    assert times_of((CASE, 2.0), (CASE, 2.0)).estimate([Job(CASE, 9)], 1) is None
    assert times_of((CASE, 2.0), (CASE, 2.0), (CASE, 2.0)).estimate([Job(CASE, 9)], 1) is not None


def test_runs_that_are_alike_tell_the_time_of_the_others() -> None:
    times = times_of(*[(CASE, 3.0)] * 4)
    found = times.estimate([Job(case, seed) for case in (CASE, OTHER) for seed in range(10, 20)], 2)
    assert found is not None
    assert found.n_runs == 20
    assert found.wall_s == pytest.approx(20 * 3.0 / 2, rel=0.05)
    assert found.min_s == pytest.approx(found.wall_s, rel=0.06)
    assert found.max_s == pytest.approx(found.wall_s, rel=0.06)


def test_a_graph_of_which_no_run_is_made_takes_as_much_of_its_limit() -> None:
    """A tenth of the limit, as those of the other graph."""
    found = times_of(*[(CASE, 6.0)] * 4).estimate([Job(LONG, 1)], 1)
    assert found is not None
    assert found.wall_s == pytest.approx(60.0, rel=0.05)


def test_what_a_variant_takes_counts_more_the_more_of_its_runs_are_made() -> None:
    def ratio(n: int) -> float:
        times = times_of(*[(CASE, 6.0)] * n, *[(OTHER, 1.0)] * n)
        base, other = (times.estimate([Job(case, 99)], 1) for case in (CASE, OTHER))
        assert base is not None
        assert other is not None
        return base.wall_s / other.wall_s

    assert 1.5 < ratio(2) < ratio(10) < ratio(100) < 6.0
    assert ratio(1000) == pytest.approx(6.0, rel=0.02)


def test_the_span_is_that_of_what_was_seen() -> None:
    def error(*took_s: float) -> float:
        found = times_of(*((CASE, one) for one in took_s)).estimate([Job(CASE, seed) for seed in range(100)], 1)
        assert found is not None
        assert 0 < found.min_s < found.wall_s < found.max_s
        return found.error_s / found.wall_s

    few, many = (1.0, 9.0) * 2, (1.0, 9.0) * 20
    assert error(5.0, 5.0, 5.0, 5.0) < 0.06 < error(*many) < 0.25 < error(*few)


def test_runs_without_a_limit_are_estimated_by_those_made() -> None:
    times = RunTimes(lambda _: None)
    for seed in range(4):
        times.add(Job(CASE, seed), 5.0)
    found = times.estimate([Job(CASE, 9), Job(CASE, 10)], 1)
    assert found is not None
    assert found.wall_s == pytest.approx(10.0, rel=0.05)


def test_a_world_is_made_once_for_the_runs_in_a_row() -> None:
    times = RunTimes(lambda _: 60.0)
    for seed in range(4):
        times.add(Job(CASE, seed), 3.0, 2.0)
        times.add(Job(OTHER, seed), 3.0, 0.1)
    for variants, worlds in ((1, 20), (2, 20), (4, 20), (5, 40)):
        cases = [replace(CASE, folder=f"runs/hall/{variant}") for variant in range(variants)]
        found = times.estimate([Job(case, seed) for seed in range(10, 30) for case in cases], 1)
        assert found is not None
        assert found.wall_s == pytest.approx(20 * variants * 3.0 + worlds * 2.0, rel=0.05)


def test_first_runs_are_from_all_over_the_study_and_each_comes_once() -> None:
    jobs = [Job(case, seed) for seed in range(20) for case in (CASE, OTHER, replace(LONG, folder="runs/laps/b"))]
    times = RunTimes(lambda _: 60.0)
    order = list(times.spread(jobs))
    assert len({job.folder for job in order}) == len(order) > len(jobs) / 2
    first = order[:6]
    assert {job.case.folder for job in first} == {job.case.folder for job in jobs}, "of every case"
    assert len({job.seed for job in first}) >= 4, "of many worlds"
    assert order == list(times.spread(jobs)), "the same each time"
    assert list(times.spread([])) == []


def test_long_runs_come_first_more_often() -> None:
    jobs = [Job(case, seed) for seed in range(20) for case in (CASE, LONG)]
    first = list(times_of().spread(jobs))[:10]
    assert sum(job.case is LONG for job in first) >= 8


@pytest.fixture
def _every_time_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (api, commands):
        monkeypatch.setattr(module, "WORTH_TELLING_S", 0.0)


TOLD = re.compile(
    r"^(\d+) runs left, 1 at once: about \d+ seconds \(.* to .*\), with pictures and report(.*)$", re.MULTILINE
)


@pytest.mark.usefixtures("_every_time_is_told")
def test_the_time_is_told_after_the_first_runs_and_again_when_it_is_resumed(
    study: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert study.run("--set", "run.until_s=0.3", seeds="0:20") == 0
    told = TOLD.search(capsys.readouterr().out)
    assert told is not None
    assert 30 <= int(told[1]) < 40, "a tenth of the runs, or a few"
    assert len(study.runs) == 40
    assert study.run("--set", "run.until_s=0.3", seeds="0:22") == 0
    told = TOLD.search(capsys.readouterr().out)
    assert told is not None
    assert told[1] == "4", "the runs of before tell it"


@pytest.mark.usefixtures("_every_time_is_told")
def test_the_bar_of_the_first_runs_tells_the_time_of_all(study: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[float] = []

    @contextmanager
    def bar(*given: Any) -> Iterator[Callable[[str], None]]:
        *_, left_s = given
        yield lambda _outcome: told.append(left_s() or 0.0)

    monkeypatch.setattr(commands, "study_bar", bar)
    assert study.run("--set", "run.until_s=0.3", seeds="0:20") == 0
    known = [seconds for seconds in told if seconds]
    assert known[0] > 3 * known[-2], "of most runs, of one"


@pytest.mark.usefixtures("_every_time_is_told")
def test_runs_are_the_same_whether_or_not_some_are_made_first(study: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    assert study.run("--set", "run.until_s=0.3", seeds="0:10") == 0
    rows, study.out = study.rows, study.out.with_name("other")
    monkeypatch.setattr(api, "FEW_RUNS", 1000)
    assert study.run("--set", "run.until_s=0.3", seeds="0:10") == 0
    assert study.rows == rows


def test_a_short_study_says_nothing(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--set", "run.until_s=0.3", seeds="0:10") == 0
    assert "runs left" not in "".join(capsys.readouterr())


@pytest.mark.usefixtures("_every_time_is_told")
def test_a_failed_first_run_ends_a_study_that_is_to_fail_fast(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--fail-fast", vary="robot.odd=raise,fine", seeds="0:20") == 1
    assert "stopped by --fail-fast" in capsys.readouterr().err
    assert len(study.runs) < 40


@pytest.mark.parametrize(
    ("wall_s", "error_s", "if_needed", "span"),
    [
        (40.0, 5.0, False, "40 seconds (35 seconds to 45 seconds), with pictures and report"),
        (450.0, 90.0, False, "7.5 minutes (6 minutes to 9 minutes), with pictures and report"),
        (
            7200.0,
            7200.0,
            True,
            "2 hours (40 minutes to 4 hours), with pictures and report, if the results need all worlds",
        ),
    ],
)
def test_it_is_told_in_words(wall_s: float, error_s: float, if_needed: bool, span: str) -> None:
    told = commands.estimate_text(TimeEstimate(60, wall_s, error_s), 2, if_needed=if_needed)
    assert told == f"60 runs left, 2 at once: about {span}"


def test_a_time_that_is_exceeded_is_told_once_more(capsys: pytest.CaptureFixture[str]) -> None:
    console = commands.StudyConsole(Console(), is_sure=True)
    left = iter([None, 50.0, 40.0, 100.0, 100.0, 10.0])
    with console.progress("toy", 0, 6, lambda: next(left)) as on_made:
        for _ in range(6):
            on_made("goal")
    said = capsys.readouterr().err
    assert said == "4 runs left, about 50 seconds\n2 runs left, about 100 seconds\n"


def test_failures_that_are_to_come_are_expected_as_often_as_among_the_first(make_plan: Any, make_record: Any) -> None:
    plan = make_plan(seeds=range(20))
    assert expected_failures(plan, [], 2) == 0.0
    arrived = [make_record("ica", seed, outcome="goal") for seed in range(4)]
    assert expected_failures(plan, arrived, 2) == 0.0
    failed = [make_record("ica", seed, outcome="contact") for seed in range(4, 8)]
    assert expected_failures(plan, arrived + failed, 2) == 4.0, "two of each variant"
    assert expected_failures(plan, arrived * 9 + failed[:1], 2) == pytest.approx(2 * 20 / 37)


@pytest.mark.parametrize("option", ["small", "replayable"])
def test_logs_keep_what_the_study_asks_for(study: Any, option: str) -> None:
    assert (
        study.run("--set", f"run.record={option}", "--set", "run.until_s=0.5", vary="robot.odd=fine,raise", seeds="0:1")
        == 0
    )
    with Recording(study.out / "runs" / "toy" / "robot.odd=fine" / "0" / RunFolder.LOG) as log:
        assert log.graph["run"]["record"] == option
