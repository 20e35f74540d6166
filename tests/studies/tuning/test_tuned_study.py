"""The study that a tuning leaves: what ran in the tuning, from wherever it is run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import graphnav

from .conftest import GRAPH

RIVALS = """\
graph: aim
seeds: 0:3
worlds: {aim: 2}
set: {score.note: mine.txt}
vary:
  aimer:
    noted: {aim.note: notes/yours.txt}
    plain: {}
metrics: [score.miss_m]
"""


@pytest.fixture
def written(aim: dict[str, Any], tmp_path: Path) -> dict[str, Any]:
    """Return the arguments of a tuning of a study in a folder of its own, whose values have paths beside it."""
    for folder in ("studies/notes", "elsewhere"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "studies/aim.yaml").write_text(GRAPH)
    (tmp_path / "studies/rivals.yaml").write_text(RIVALS)
    (tmp_path / "studies/mine.txt").write_text("0.5")
    (tmp_path / "studies/notes/yours.txt").write_text("0.25")
    return {"study": "studies/rivals.yaml", "trials": 2, "plugins": aim["plugins"], "jobs": 1}


def misses(study: graphnav.Study, variant: str) -> dict[int, float]:
    return {run.seed: run.metrics["score.miss_m"] for run in study.records if run.variant == variant}


def test_paths_and_worlds_are_those_of_the_tuning(
    written: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tuned = graphnav.tune(**written, folder="out/tuned")
    assert "# graphnav ablate tuned.yaml --plugin ../../my_aims.py --seeds 1000:1050\n" in tuned.study.read_text()
    monkeypatch.chdir(tmp_path / "elsewhere")
    judged = graphnav.ablate(tuned.study, seeds=range(3), plugins=["../my_aims.py"], jobs=1)
    default = next(trial for trial in tuned.trials if trial.rival == "noted")
    assert misses(judged, "noted as it is") == {
        seed: value for (_, seed), value in default.values["score.miss_m"].items()
    }
    assert min(misses(judged, "noted as it is")) == 0
    assert max(misses(judged, "noted as it is")) == 1
    assert misses(judged, "noted as it is")[0] == 2.0 + 0.5 + 0.25


def test_it_may_be_moved_with_what_it_refers_to(
    written: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "all").mkdir()
    (tmp_path / "studies").rename(tmp_path / "all" / "studies")
    monkeypatch.chdir(tmp_path / "all")
    graphnav.tune(**written | {"plugins": ["../my_aims.py"]}, folder="tuned")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "all").rename(tmp_path / "moved")
    judged = graphnav.ablate("moved/tuned/tuned.yaml", seeds=[0], plugins=["my_aims.py"], jobs=1)
    assert misses(judged, "noted as it is") == {0: 2.0 + 0.5 + 0.25}


def test_paths_of_options_are_found_where_they_were_given(aim: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("0.5")
    (tmp_path / "better.txt").write_text("-0.5")
    asked = aim | {"vary": {"aim": ["aim.near", "aim.fixed"]}, "trials": 2, "metrics": ["score.miss_m"]}
    tuned = graphnav.tune(
        **asked, set={"score.note": "mine.txt"}, search=["aim.note=better.txt", "aim.gain=0.9:1.2"], folder="out/tuned"
    )
    assert tuned.best["aim.near"]["aim.note"] == "better.txt"
    assert "score.note: ../../mine.txt" in tuned.study.read_text()
    judged = graphnav.ablate(tuned.study, seeds=[0], plugins=aim["plugins"], jobs=1)
    best = tuned.run.best(tuned.run.tuning.rivals[0]).values["score.miss_m"]["aim", 0]
    assert misses(judged, "aim.near tuned") == {0: best}


def test_the_seeds_and_trials_that_it_names_are_those_that_ran(written: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "studies/other.yaml").write_text(GRAPH)
    study = tmp_path / "studies/rivals.yaml"
    study.write_text(RIVALS.replace("graph: aim", "graphs: [aim, other]"))
    tuned = graphnav.tune(**written | {"trials": 1})
    worlds = "0, 1 of studies/aim.yaml; 0, 1, 2 of studies/other.yaml"
    assert f"# Tuned in the worlds {worlds}, with 1 trial of each rival: judge them" in tuned.study.read_text()
    assert f"in the worlds {worlds}.\n" in (tuned.folder / "tuned.md").read_text()
