"""Which runs are begun first, and how long those left take."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from graphnav import Recording
from graphnav.core.run_folder import RunFolder
from graphnav.studies.ablation.execution import RunTimes
from graphnav.studies.ablation.execution.run_times import longest_first
from graphnav.studies.ablation.plan import Case, Job

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


def test_the_time_left_is_that_of_the_case_else_of_its_graph() -> None:
    times, jobs = RunTimes(), [Job(CASE, 1), Job(OTHER, 1), Job(LONG, 1)]
    times.add(CASE, 2.0)
    assert times.left_s(jobs[:2], 2) is None, "one run is the first in its world, which takes longer"
    times.add(CASE, 4.0)
    times.add(CASE, 3.0)
    assert times.left_s(jobs, 2) is None, "nothing is known of laps"
    assert times.left_s(jobs[:2], 2) == pytest.approx((3.0 + 3.0) / 2)
    times.add(OTHER, 9.0)
    for took_s in (29.0, 30.0, 31.0):
        times.add(LONG, took_s)
    assert times.left_s(jobs, 2) == pytest.approx((3.0 + 9.0 + 30.0) / 2)
    assert times.left_s([], 2) == 0.0


@pytest.mark.parametrize("option", ["small", "replayable"])
def test_logs_keep_what_the_study_asks_for(study: Any, option: str) -> None:
    assert (
        study.run("--set", f"run.record={option}", "--set", "run.until_s=0.5", vary="robot.odd=fine,raise", seeds="0:1")
        == 0
    )
    with Recording(study.out / "runs" / "toy" / "robot.odd=fine" / "0" / RunFolder.LOG) as log:
        assert log.graph["run"]["record"] == option
