"""The graph navigate: what it knows, what it drives, and that it drives in every world of the suite."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import dist
from statistics import mean

import pytest

from graphnav import Recording, State, Twist
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph, shipped_graphs
from graphnav.core.runner.recording.summary import Summary
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.study.find_study import shipped_studies
from graphnav.studies.ablation.study.study_file import load_study

GRAPHS = sorted(name for name in shipped_graphs() if name.split("/")[0] in ("navigate", "navigate_robot"))
LENS = "navigate/lens"
"""Its knowledge of the camera is measured, near the truth."""
STUDIES = sorted(name for name in shipped_studies() if name.startswith("navigate"))
BEACON = "robot.goal"


@pytest.fixture(scope="module")
def catalog() -> Catalog:
    return Catalog()


def upstream(graph: Graph, name: str) -> set[str]:
    """Return the channels that a stage depends on."""
    found: set[str] = set()
    pending = [name]
    while pending:
        for read in graph.node(pending.pop()).inputs:
            if read.channel is None or read.channel.ref in found:
                continue
            found.add(read.channel.ref)
            writer = read.channel.ref.partition(".")[0]
            pending += [writer] * any(node.name == writer for node in graph.nodes)
    return found


@pytest.mark.parametrize("name", GRAPHS)
def test_a_camera_a_beacon_and_the_limits_of_its_base_are_all_that_it_knows(name: str, catalog: Catalog) -> None:
    graph = load_graph(name, catalog)
    outside = {"robot", "camera", "base", "operator"}
    known = {ref for ref in upstream(graph, "control") if ref.partition(".")[0] in outside}
    assert known <= {"robot.image", "camera.image", BEACON, "robot.limits", "base.limits"}
    assert {"robot.image", "camera.image"} & known


@pytest.mark.parametrize("name", GRAPHS)
def test_odometry_and_map_know_the_mounting_of_the_robots_camera(name: str, catalog: Catalog) -> None:
    graph = load_graph(name, catalog)
    nodes = [*graph.nodes, *load_graph("robot_live", catalog).nodes]
    robot = next(node.params for node in nodes if node.name == "robot")
    for stage in ("egomotion", "local"):
        params = graph.node(stage).params
        for param in ("camera_height_m", "tilt_deg", "fov_deg"):
            assert params[param] == (pytest.approx(robot[param], 5e-3) if name == LENS else robot[param]), param


def test_every_world_of_the_suite_has_its_graph() -> None:
    worlds = {name.removeprefix("suite/") for name in load_study("suite").graphs}
    assert {f"navigate/{world}" for world in worlds} < set(GRAPHS)
    assert set(load_study("navigate_suite").graphs) == set(GRAPHS) - {"navigate", "navigate_robot", LENS}


@pytest.mark.parametrize("world", sorted(name.removeprefix("suite/") for name in load_study("suite").graphs))
def test_the_world_is_that_of_the_suite(world: str, catalog: Catalog) -> None:
    ours, theirs = (load_graph(f"{family}/{world}", catalog) for family in ("navigate", "suite"))
    assert ours.node("robot").params == theirs.node("robot").params
    assert ours.run == theirs.run
    speeds = [graph.node("control").params["max_speed_mps"] for graph in (ours, theirs)]
    assert speeds[0] == speeds[1]


@pytest.mark.parametrize("name", STUDIES)
def test_every_graph_of_a_study_with_every_method_is_right(name: str, catalog: Catalog) -> None:
    checked = check_study(replace(load_study(name), seeds=(0,)), catalog, "")
    assert "navigate" in checked.plan.axes["method"]


def test_the_parts_add_up_to_the_graph_navigate(catalog: Catalog) -> None:
    checked = check_study(replace(load_study("navigate_parts"), seeds=(0,)), catalog, "")
    built = {folder: graph for folder, graph in checked.graphs.items() if folder.endswith("/navigate")}
    assert len(built) == len(load_study("navigate_parts").graphs)
    for folder, graph in built.items():
        world = folder.removesuffix("/navigate").split("/")[-1]
        shipped = load_graph(f"navigate/{world}", catalog)
        for stage in ("flow", "plane", "egomotion", "local", "steer", "recovery", "control"):
            assert graph.node(stage).use == shipped.node(stage).use
            assert graph.node(stage).params == shipped.node(stage).params


@pytest.mark.parametrize("name", ["navigate", "navigate/corners"])
def test_it_sets_out_by_what_it_sees(drive: Callable[..., tuple[Summary, Recording]], name: str) -> None:
    summary, log = drive(name, 3, "run.until_s=4")
    assert not summary.failure
    places = [(m.x_m, m.y_m) for _, _, m in log.messages("robot.state") if isinstance(m, State)]
    assert sum(dist(a, b) for a, b in pairwise(places)) > 0.2


@pytest.mark.long
def test_on_a_base_that_brakes_slowly_it_drives_more_slowly(
    drive: Callable[..., tuple[Summary, Recording]],
) -> None:
    # 1.0 m/s in 1/0.3 s: 0.3 m/s2, where the shipped base has 4.
    asked_mps = []
    for slower in ((), ("robot.speed_up_s=3.3333",), ("robot.speed_up_s=3.3333", "control.in.limits=null")):
        summary, log = drive("navigate/speed", 3, "run.until_s=4", *slower)
        assert not summary.failure
        speeds = [m.v_mps for _, _, m in log.messages("control.twist") if isinstance(m, Twist)]
        asked_mps.append(mean(speeds[20:]))
    fast, slow, untold = asked_mps
    assert slow < 0.75 * fast
    assert slow < untold, "what it counts on without limits is more than this base does"
