"""``graphnav.ablate``: the study that the command makes, as tables."""

from __future__ import annotations

import gc
import shlex
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import graphnav
from graphnav import UserError
from graphnav.core.cli import main
from graphnav.studies.ablation.execution import read_plan

TOYS = Path(__file__).parents[1] / "ablation" / "execution" / "toy_stages.py"
GRAPH = """\
run: {until_s: 5}
stages:
  robot: {use: toy.walker}
  drive: {use: toy.distance, in: {twist: robot}}
"""
VARY = {"robot.odd": ["fine", "contact"]}


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the arguments of a study of two variants and four seeds."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "toy.yaml").write_text(GRAPH)
    shutil.copy(TOYS, tmp_path / "my_toys.py")
    return {"study": "toy", "vary": VARY, "plugins": ["my_toys.py"], "seeds": range(4), "jobs": 1, "gallery": 0}


def test_it_is_the_study_of_the_command(toy: dict[str, Any], tmp_path: Path) -> None:
    study = graphnav.ablate(**toy, folder="door")
    words = shlex.split(study.plan.command)
    assert words[:3] == ["graphnav", "ablate", "toy"]
    assert main([*words[1:], "--gallery", "0", "-j", "2", "-o", "out"]) == 0
    assert (tmp_path / "door" / "results.csv").read_bytes() == (tmp_path / "out" / "results.csv").read_bytes()
    assert replace(read_plan(tmp_path / "out"), command="") == replace(read_plan(tmp_path / "door"), command="")
    assert study.folder == tmp_path / "door"
    assert study.report.read_text().startswith("<!doctype html>")


def test_the_tables_are_those_of_the_files(toy: dict[str, Any]) -> None:
    study = graphnav.ablate(**toy)
    written = pd.read_csv(study.folder / "results.csv", keep_default_na=False)
    pd.testing.assert_frame_equal(study.runs, written, check_dtype=False)
    assert study.table.index.names == ["graph", "metric", "variant"]
    base, other = (study.table.loc[("toy", "drive.way_m", f"robot.odd={odd}")] for odd in ("fine", "contact"))
    ways = study.runs.pivot(index="seed", columns="variant", values="drive.way_m")
    assert base["mean"] == pytest.approx(ways["robot.odd=fine"].mean())
    assert other["difference"] == pytest.approx((ways["robot.odd=contact"] - ways["robot.odd=fine"]).mean())
    assert (base["worlds"], other["worlds"], other["lost"], other["won"]) == (4, 4, 3, 0)
    assert np.isnan(base["difference"])
    assert not other["clear"]
    assert "robot.odd=contact" in str(study)
    assert "<pre>" in study._repr_html_()


def test_two_variants_are_contrasted(toy: dict[str, Any]) -> None:
    study = graphnav.ablate(**toy)
    found = study.contrast("robot.odd=contact", "robot.odd=fine")
    assert found.index.names == ["graph", "metric"]
    row, base = found.loc[("toy", "drive.way_m")], study.table.loc[("toy", "drive.way_m", "robot.odd=contact")]
    for name in ("difference", "difference_low", "difference_high", "won", "lost", "p"):
        assert row[name] == base[name], "one variant is the base"
    assert row["won"] + row["tied"] + row["lost"] == row["worlds"] == 4
    assert row["probability_better"] == (row["won"] + row["tied"] / 2) / 4
    other = study.contrast("robot.odd=fine", "robot.odd=contact").loc[("toy", "drive.way_m")]
    assert other["difference"] == -row["difference"]
    with pytest.raises(UserError, match=r"the study has no variant 'robot.odd=fin'\n  did you mean 'robot.odd=fine'"):
        study.contrast("robot.odd=contact", "robot.odd=fin")


def test_more_seeds_add_to_the_runs_that_are_there(toy: dict[str, Any], tmp_path: Path) -> None:
    graphnav.ablate(**toy, folder="out")
    made = {path: path.stat().st_mtime_ns for path in tmp_path.glob("out/runs/*/*/*/summary.json")}
    study = graphnav.ablate(**toy | {"seeds": [0, 1, 2, 3, np.int64(7)]}, folder="out")
    assert len(made) == 8
    assert all(path.stat().st_mtime_ns == before for path, before in made.items())
    assert len(study.records) == 10


def test_failures_are_results(toy: dict[str, Any]) -> None:
    study = graphnav.ablate(**toy | {"vary": {"robot.odd": ["fine", "raise"]}})
    assert study.runs.groupby("variant")["outcome"].value_counts().to_dict() == {
        ("robot.odd=fine", "goal"): 4, ("robot.odd=raise", "goal"): 1, ("robot.odd=raise", "failed"): 3,
    }  # fmt: skip


def test_a_temporary_folder_goes_with_the_study(toy: dict[str, Any], tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    study = graphnav.ablate(**toy)
    folder = study.folder
    assert (folder / "results.csv").is_file()
    assert sorted(tmp_path.iterdir()) == before
    del study
    gc.collect()
    assert not folder.exists()


def test_without_pandas_the_comparison_is_still_there(toy: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    study = graphnav.ablate(**toy)
    monkeypatch.setitem(sys.modules, "pandas", None)
    for name in ("runs", "table"):
        with pytest.raises(UserError, match=rf"^Study.{name} needs pandas\n  pip install 'pandas>=2\.1'$"):
            getattr(study, name)
    assert study.comparison.rows[0].estimates["drive.way_m"].n == 4
    assert "4" in str(study)


SEEDS = "write seeds=range(1000, 1010), or [1, 5, 7]"
VARIES = 'write vary={"plane": ["plane.ica", "plane.affine"]}'
NAMES = 'write "corridor_ccw", or ["corridor_ccw", "pillars"]'


ORDER = "the base's first (a set has no order)"
ITSELF = "one that contains itself"
ENDLESS: list[object] = [1]
ENDLESS.append(ENDLESS)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"study": 3}, 'study must be a path, not 3 (int)\n  write study="corridor_ccw"'),
        ({"study": []}, f"study names no graph\n  {NAMES}"),
        ({"vary": ["plane"]}, f"vary must be a mapping, not ['plane'] (list)\n  {VARIES}"),
        (
            {"vary": {"plane": "plane.ica"}},
            f"vary['plane'] must be a list of values, not 'plane.ica' (str)\n  {VARIES}",
        ),
        (
            {"vary": {"plane": {"plane.ica"}}},
            f"vary['plane'] must be a list of values, {ORDER}, not {{'plane.ica'}} (set)\n  {VARIES}",
        ),
        (
            {"set": {"robot.times": ENDLESS}},
            f"set['robot.times'] has lists in more than 20 others, or {ITSELF}\n  write a list of values",
        ),
        ({"reference": 3}, 'reference must be the name of a variant, not 3 (int)\n  write reference="steer.oracle"'),
        (
            {"worlds": {"toy": 0}},
            "worlds['toy'] must be an integer of at least 1, not 0 (int)\n  write worlds['toy']=2",
        ),
        (
            {"worlds": {"toy": None}},
            "worlds['toy'] must be an integer of at least 1, not None\n  write worlds['toy']=2",
        ),
        (
            {"worlds": 3},
            'worlds must be a mapping of graphs to numbers, not 3 (int)\n  write worlds={"suite/laps": 10}',
        ),
        ({"vary": {1: []}}, f"vary: 1 is not a stage, a parameter or a wire\n  {VARIES}"),
        ({"seeds": 10}, f"seeds must be a range or a list of integers, not 10 (int)\n  {SEEDS}"),
        ({"seeds": "0:10"}, f"seeds must be a range or a list of integers, not '0:10' (str)\n  {SEEDS}"),
        ({"seeds": [1.5]}, f"seeds must be a range or a list of integers, not 1.5 (float)\n  {SEEDS}"),
        ({"seeds": [-1]}, f"seeds: a seed must be 0 or more, not -1\n  {SEEDS}"),
        ({"seeds": range(0)}, f"seeds is empty\n  {SEEDS}"),
        ({"metrics": "a.b"}, "metrics must be a list, not 'a.b' (str)\n  write metrics=[\"drive.success\"]"),
        ({"metrics": [3]}, 'metrics[0] must be a string, not 3 (int)\n  write metrics=["drive.success"]'),
        ({"jobs": 0}, "jobs must be an integer of at least 1, not 0 (int)\n  write jobs=2"),
        ({"gallery": -1}, "gallery must be an integer of at least 0, not -1 (int)\n  write gallery=2"),
        ({"cluster": 8786}, 'cluster must be a string or None, not 8786 (int)\n  write cluster="tcp://host:8786"'),
        ({"folder": 3}, 'folder must be a path, not 3 (int)\n  write folder="ablations/1"'),
        ({"vary": None}, "the study varies nothing\n  write --vary plane=plane.ica,plane.affine, or name a study"),
    ],
)
def test_a_wrong_argument_is_refused_before_anything_runs(
    toy: dict[str, Any], tmp_path: Path, arguments: dict[str, Any], said: str
) -> None:
    with pytest.raises(UserError) as error:
        graphnav.ablate(**({**toy, "folder": "out"} | arguments))
    assert str(error.value) == said
    assert not (tmp_path / "out").exists()


def test_a_loaded_graph_is_no_study(toy: dict[str, Any]) -> None:
    with pytest.raises(UserError, match=r"^study names graphs by their files, and this is a loaded graph"):
        graphnav.ablate(**toy | {"study": graphnav.load("toy", plugins=["my_toys.py"])})
