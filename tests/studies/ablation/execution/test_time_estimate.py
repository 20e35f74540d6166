"""The core-hours of a study before it starts."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override
from graphnav.studies.ablation.execution import TaskFactory, TimeEstimate, estimate_time, local_workers
from graphnav.studies.ablation.plan import CheckedStudy, check_study
from graphnav.studies.ablation.results import Record
from graphnav.studies.ablation.study import parse_varies, study_of_command
from graphnav.studies.commands.study_run import _estimate_text


@pytest.fixture
def checked(study: Any) -> CheckedStudy:
    catalog = Catalog()
    catalog.add_file(Path(study.plugin))
    varies = parse_varies(["robot.odd=fine,contact"], [])
    overrides = [Override.parse("robot.times=100")]
    asked = study_of_command(["toy"], varies=varies, overrides=overrides, seeds="0:10")
    return check_study(asked, catalog, "", [Path(study.plugin)])


def estimate(checked: CheckedStudy, records: list[Record], scratch: Path) -> TimeEstimate:
    with local_workers(1, scratch) as workers:
        return estimate_time(list(checked.plan.jobs), records, TaskFactory(checked), workers)


def test_existing_runs_tell_the_pace(checked: CheckedStudy, make_record: Any, tmp_path: Path) -> None:
    """0.1 s of wall time for 0.9 simulated seconds, 20 runs of at most 5 s."""
    found = estimate(checked, [make_record("robot.odd=fine", 0, graph="toy")], tmp_path)
    assert (found.n_runs, found.n_unknown) == (20, 0)
    assert found.core_s == pytest.approx(20 * 5 * 0.1 / 0.9)


def test_else_a_short_run_does(checked: CheckedStudy, tmp_path: Path) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    found = estimate(checked, [], scratch)
    assert (found.n_runs, found.n_unknown) == (20, 0)
    assert found.core_s > 0
    assert list(scratch.iterdir()) == [], "nothing of it is kept"


def test_a_large_study_says_it_and_a_small_one_does_not(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--set", "run.until_s=0.3", seeds="0:51") == 0
    said = capsys.readouterr().out
    assert re.search(
        r"^102 runs, 1 at once: about \S+ core-hours \(\S+ \S+\) if each lasts until its time limit and costs what the "
        r"first does$",
        said,
        re.MULTILINE,
    )
    assert study.run("--set", "run.until_s=0.3", seeds="0:52") == 0
    assert "core-hours" not in capsys.readouterr().out


def test_runs_without_a_limit_have_no_bound(study: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert study.run("--set", "run.until_s=null", seeds="0:51") == 0
    assert "102 runs, 1 at once; they have no time limit" in capsys.readouterr().out


UNKNOWN = "4 runs, 2 at once; how long they take is not known"


@pytest.mark.parametrize(
    ("n_unlimited", "message"),
    [
        (4, "4 runs, 2 at once; they have no time limit"),
        (0, f"{UNKNOWN}, because the run that measures it failed"),
        (
            1,
            f"{UNKNOWN}: 1 of them has no time limit, and the run that measures the others failed",
        ),
    ],
)
def test_it_says_why_nothing_is_known(n_unlimited: int, message: str) -> None:
    assert _estimate_text(TimeEstimate(4, 0.0, 4, n_unlimited), 2) == message


def test_a_measuring_run_that_fails_is_no_missing_limit(checked: CheckedStudy) -> None:
    workers: Any = SimpleNamespace(perform_all=lambda tasks: [SimpleNamespace(died=True) for _ in tasks])
    found = estimate_time(list(checked.plan.jobs), [], TaskFactory(checked), workers)
    assert (found.n_runs, found.n_unknown, found.n_unlimited) == (20, 20, 0)
