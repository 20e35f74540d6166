"""The studies of rivals with equal knowledge: what is the same for all, and what is tuned."""

from __future__ import annotations

from dataclasses import replace

import pytest
import tune_rivals

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph
from graphnav.studies.ablation.plan import check_study
from graphnav.studies.ablation.study import Study
from graphnav.studies.ablation.study.study_file import load_study

WORLDS = ("doors", "speed", "tilt")
"""The speeds and the camera of most worlds, and those that differ."""
SAME = ("flow", "egomotion", "local", "guard")
PLANNERS = {"vfh", "dwa", "gap"}


@pytest.fixture(scope="module")
def catalog() -> Catalog:
    return Catalog()


def graphs_of(study: Study, catalog: Catalog) -> dict[tuple[str, str], Graph]:
    """Return the graph of each world and method."""
    checked = check_study(replace(study, seeds=(1,), worlds={}), catalog, "")
    return {(case.graph, case.variant): checked.graphs[case.folder] for case in checked.plan.cases}


@pytest.fixture(scope="module")
def graphs(catalog: Catalog) -> dict[tuple[str, str], Graph]:
    return graphs_of(replace(load_study("rivals"), graphs=tuple(f"rivals/{world}" for world in WORLDS)), catalog)


@pytest.fixture(scope="module")
def barn(catalog: Catalog) -> dict[tuple[str, str], Graph]:
    return graphs_of(load_study("rivals_barn"), catalog)


@pytest.mark.long
def test_all_have_the_map_the_motion_and_the_guard_of_navigate(
    graphs: dict[tuple[str, str], Graph], barn: dict[tuple[str, str], Graph], catalog: Catalog
) -> None:
    for (name, method), graph in (graphs | barn).items():
        world = name.removeprefix("rivals/")
        navigate = load_graph("barn_navigate" if world == "barn" else f"navigate/{world}", catalog)
        for stage in SAME:
            own, other = dict(graph.node(stage).params), dict(navigate.node(stage).params)
            if method.endswith("truth"):
                assert own.pop("blind_height_m", 0.0) == 0.0
                other.pop("blind_height_m", None)
            assert (graph.node(stage).use, own) == (navigate.node(stage).use, other), (name, method, stage)
        if not method.startswith("dwa"):
            own, other = (dict(one.node("control").params) for one in (graph, navigate))
            assert (own.pop("max_decel_mps2"), own.pop("reaction_s")) == (0.5, 0.25), "as steer.dwa, which is told"
            assert (other.pop("max_decel_mps2"), other.pop("reaction_s")) == (None, None)
            own.pop("reversing"), other.pop("reversing")
            if world == "barn":
                assert (own.pop("max_speed_mps"), other.pop("max_speed_mps")) == (1.0, 1.5)
            assert own == other, (name, method)


@pytest.mark.long
def test_no_rival_reads_odometry_and_only_oracles_the_truth(graphs: dict[tuple[str, str], Graph]) -> None:
    for (_, method), graph in graphs.items():
        for node in graph.nodes:
            read = {one.channel.ref for one in node.inputs if one.channel is not None}
            assert "robot.motion" not in read
            if node.stage_class.role != "score" and "robot.truth" in read:
                assert node.name == "plane"
                assert method.endswith("truth")


@pytest.mark.long
def test_the_window_has_the_limits_of_the_control(
    graphs: dict[tuple[str, str], Graph], barn: dict[tuple[str, str], Graph]
) -> None:
    both = graphs | barn
    for name in {name for name, _ in both}:
        steer, control = both[name, "dwa"].node("steer").params, both[name, "homography"].node("control").params
        for limit in ("max_speed_mps", "max_turn_radps", "max_decel_mps2", "reaction_s", "robot_radius_m"):
            assert steer[limit] == control[limit], (name, limit)


@pytest.mark.long
def test_every_planner_knows_the_robot_of_barn(barn: dict[tuple[str, str], Graph]) -> None:
    for graph in barn.values():
        assert graph.node("steer").params["robot_radius_m"] == 0.27


def test_both_studies_have_the_same_methods_and_the_suites_first_thirteen_worlds() -> None:
    study, barn = load_study("rivals"), load_study("rivals_barn")
    assert [axis.choices for axis in study.axes] == [axis.choices for axis in barn.axes]
    worlds = [name.partition("/")[2] for name in load_study("suite").graphs]
    assert [name.partition("/")[2] for name in study.graphs] == worlds[:13]


def settings(study: Study, method: str) -> dict[str, object]:
    [axis] = study.axes
    choice = next(one for one in axis.choices if one.label == method)
    return {str(override.target): override.value for override in choice.overrides}


@pytest.mark.long
@pytest.mark.parametrize("method", list(tune_rivals.METHODS))
def test_the_parameters_of_a_method_are_those_of_one_of_its_trials(
    graphs: dict[tuple[str, str], Graph], barn: dict[tuple[str, str], Graph], method: str
) -> None:
    trials = tune_rivals.trials_of(method)
    assert len(trials) == tune_rivals.N_TRIALS
    for world, of in (("rivals/doors", graphs), ("rivals/barn", barn)):
        graph = of[world, "homography" if method == "frontier" else method]
        own = {f"{node.name}.{name}": value for node in graph.nodes for name, value in node.params.items()}
        assert any(own.items() >= trial.items() for trial in trials), world


@pytest.mark.parametrize("planner", sorted(PLANNERS))
def test_a_planner_has_the_same_parameters_on_the_true_obstacles(planner: str) -> None:
    seen, true = (settings(load_study("rivals"), method) for method in (planner, f"{planner} truth"))
    base = settings(load_study("rivals"), "homography")
    assert {name: value for name, value in seen.items() if name.startswith("steer")} == {
        name: value for name, value in true.items() if name.startswith("steer")
    }
    assert {name: value for name, value in seen.items() if name.startswith("plane")} == {
        name: value for name, value in base.items() if name.startswith("plane")
    }
