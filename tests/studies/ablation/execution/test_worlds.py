"""A graph of a study may have fewer worlds than the others."""

from __future__ import annotations

import json
import shutil
from typing import Any

import pytest

import graphnav
from graphnav.core.cli import main


@pytest.fixture
def two(study: Any) -> Any:
    """Return a toy study of two graphs, the second one with the first two seeds only."""
    shutil.copy(study.graph, study.graph.with_name("other.yaml"))
    study.graph.with_name("both.yaml").write_text(
        "graphs: [toy, other]\nworlds: {other: 2}\nseeds: 0:4\nvary: {robot.odd: [fine, contact]}\n"
    )
    return study


def words(study: Any, *more: str) -> list[str]:
    own = ["--plugin", str(study.plugin), "-j", "1", "--gallery", "0", "-o", str(study.out)]
    return ["ablate", "both", *own, *more]


def test_it_has_the_first_seeds_and_more_are_added(two: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words(two)) == 0
    assert {(row["graph"], row["seed"]) for row in two.rows} == {
        *(("toy", str(seed)) for seed in range(4)),
        ("other", "0"),
        ("other", "1"),
    }
    assert "pending" not in capsys.readouterr().out
    assert "seeds: `0 to 3 (4); other: the first 2`" in (two.out / "table.md").read_text()
    assert "0 to 3 (4); other: the first 2, the same for all variants" in (two.out / "report.html").read_text()
    before = two.runs
    assert len(before) == 12
    assert main(words(two, "--worlds", "other=3")) == 0
    assert "12 of 14 runs are finished already" in capsys.readouterr().out
    assert before.items() <= two.runs.items()
    assert json.loads((two.out / "plan.json").read_text())["worlds"] == {"other": 3}


def test_missing_runs_are_counted_of_its_own_worlds(two: Any, capsys: pytest.CaptureFixture[str]) -> None:
    main(words(two))
    shutil.rmtree(two.out / "runs" / "other" / "robot.odd=fine" / "1")
    capsys.readouterr()
    assert main(["ablate", "--report", str(two.out)]) == 0
    said = capsys.readouterr().out
    assert "1 of 2" in said
    assert "1 of 12 runs are pending" in said


def test_from_python_they_are_a_mapping(two: Any) -> None:
    study = graphnav.ablate("both", worlds={"other": 1}, plugins=[two.plugin], jobs=1, gallery=0)
    assert study.runs.groupby("graph").size().to_dict() == {"other": 2, "toy": 8}
    assert "--worlds other=1" in study.plan.command


def test_more_than_the_seeds_are_all_of_them(two: Any) -> None:
    study = graphnav.ablate("both", worlds={"other": 9}, seeds=[5], plugins=[two.plugin], jobs=1, gallery=0)
    assert study.runs.groupby("graph").size().to_dict() == {"other": 2, "toy": 2}
    assert study.plan.n_jobs == 4
