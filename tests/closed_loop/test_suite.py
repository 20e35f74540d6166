"""The suite: every world can be drawn, is under the condition that its study names, and can be compared."""

from __future__ import annotations

from dataclasses import replace
from math import dist
from pathlib import Path
from typing import Any

import pytest
import yaml
from graphnav_world.maps.world_map import load_map

import graphnav
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_graphs
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.study.find_study import shipped_studies
from graphnav.studies.ablation.study.study_file import load_study

GRAPHS = sorted(name for name in shipped_graphs() if name.startswith("suite/"))
WORLDS = [
    "shake",
    "odometry",
    "speed",
    "corners",
    "tight",
    "doors",
    "low",
    "crowd",
    "crossers",
    "tilt",
    "light",
    "neutral",
    "laps",
]
LAYOUTS = ["poles", "spiral", "maze", "office", "tiles", "faint"]
"""The worlds of the suite that no table of the thirteen others has."""
SWEEPS = sorted(name for name in shipped_studies() if name.startswith("suite_"))
METHODS = ["ica", "homography", "residual subspace", "truth", "oracle"]
RADIUS_M = 0.2


@pytest.fixture(scope="module")
def catalog() -> Catalog:
    return Catalog()


def param(graph: str, target: str, catalog: Catalog) -> Any:
    stage, name = target.split(".")
    return next(node for node in load_graph(graph, catalog).nodes if node.name == stage).params[name]


@pytest.mark.parametrize("name", GRAPHS)
def test_ten_different_worlds_can_be_drawn(name: str, catalog: Catalog) -> None:
    path = Path(param(name, "robot.map", catalog))
    starts = {load_map(path, seed, RADIUS_M).draw.start for seed in range(10)}
    assert len(starts) == 10


def test_the_suite_has_nineteen_worlds_and_compares_with_the_oracle() -> None:
    suite = load_study("suite")
    assert list(suite.graphs) == [f"suite/{world}" for world in (*WORLDS, *LAYOUTS)]
    assert suite.reference == "oracle"
    assert dict(suite.worlds) == {"suite/laps": 10}
    assert str(suite.metrics[0]) == "drive.success"


@pytest.mark.parametrize(
    ("graph", "target", "value"),
    [
        ("shake", "robot.camera_shake_deg", 0.5),
        ("shake", "robot.camera_bob_ratio", 0.03),
        ("odometry", "robot.odometry_scale_ratio", 0.25),
        ("speed", "robot.max_speed_mps", 1.0),
        ("speed", "control.max_speed_mps", 1.0),
        ("speed", "robot.rate_hz", 20.0),
        ("tilt", "robot.tilt_deg", 50.0),
        ("light", "robot.light_swing_ratio", 0.3),
        ("neutral", "robot.neutral", True),
    ],
)
def test_every_world_is_under_its_main_condition(graph: str, target: str, value: Any, catalog: Catalog) -> None:
    assert param(f"suite/{graph}", target, catalog) == value


def test_where_walls_fill_the_picture_its_frames_count(tmp_path: Path) -> None:
    """At seed 3 more than half of every frame is wall, which `score.plane` leaves out by default."""
    run = graphnav.run("suite/crowd", seed=3, until_s=4.0, folder=tmp_path / "run", pictures=False)
    assert run.metrics["sight.counted_frames_ratio"] > 0.9


@pytest.mark.parametrize("name", ["suite", *SWEEPS])
def test_every_graph_of_a_study_with_every_method_is_right(name: str, catalog: Catalog) -> None:
    checked = check_study(replace(load_study(name), seeds=(0,)), catalog, "")
    assert set(checked.plan.axes["method"]) >= set(METHODS)


def test_the_study_of_layouts_drives_the_chain_and_navigate_in_each(catalog: Catalog) -> None:
    study = load_study("layouts")
    assert list(study.graphs) == [f"{family}/{world}" for world in LAYOUTS for family in ("suite", "navigate")]
    checked = check_study(replace(study, seeds=(0,)), catalog, "")
    assert list(checked.plan.axes["method"]) == ["as it is", "truth"]


def test_the_way_into_the_spiral_leads_around_the_goal(catalog: Catalog) -> None:
    world = load_map(Path(param("suite/spiral", "robot.map", catalog)), 0, RADIUS_M)
    assert world.shortest_m > 3 * dist(world.draw.start[:2], world.draw.goal_m.mean(axis=0))


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_begins_with_the_condition_of_the_suite(name: str) -> None:
    sweep = load_study(name)
    methods, conditions = sweep.axes
    assert [choice.label for choice in methods.choices] == METHODS
    assert tuple(sweep.within) == (conditions.name,) == ("condition",)
    assert not conditions.choices[0].overrides
    assert set(sweep.graphs) <= set(GRAPHS)
    assert set(sweep.graphs) & set(load_study("suite").graphs)


def test_a_short_study_of_the_suite_runs(tmp_path: Path) -> None:
    keys = yaml.safe_load(shipped_studies()["suite"].read_text(encoding="utf-8"))
    methods = keys["vary"]["method"]
    keys["graphs"] = ["suite/corners", "suite/laps"]
    keys["vary"]["method"] = {name: methods[name] for name in ("ica", "oracle")}
    path = tmp_path / "short.yaml"
    path.write_text(yaml.safe_dump(keys), encoding="utf-8")
    study = graphnav.ablate(path, seeds=[0], set={"run.until_s": 1}, folder=tmp_path / "study", jobs=1, gallery=0)
    runs = study.runs
    assert len(runs) == 4
    assert set(runs["outcome"]) == {"timeout"}
    assert set(runs["drive.success"]) == {0.0}
