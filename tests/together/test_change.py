"""Changes that a running graph takes, and refuses, of graphs that ship."""

from __future__ import annotations

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, Override, changed_graph, load_graph

CATALOG = Catalog()


def _loaded(name: str) -> Graph:
    return load_graph(name, CATALOG)


def _changed(graph: Graph, *sets: str, began: Graph | None = None) -> Graph:
    return changed_graph(graph, began or graph, [*map(Override.parse, sets)], CATALOG).graph


def _refusal(graph: Graph, *sets: str) -> str:
    with pytest.raises(UserError) as refused:
        _changed(graph, *sets)
    return str(refused.value)


def test_a_stage_that_nothing_reads_any_more_stays_and_can_be_read_again() -> None:
    began = _loaded("corridor_ccw")
    swapped = _changed(began, "plane=plane.affine", "plane.threshold_px=0.4")
    assert [node.name for node in swapped.nodes] == [node.name for node in began.nodes]
    assert swapped.node("plane").params["threshold_px"] == 0.4
    assert "planar.planar" not in swapped.read
    back = _changed(swapped, "plane=plane.ica", began=began)
    assert {i.port.name: i.channel and i.channel.ref for i in back.node("plane").inputs} == {
        "flow": "flow.flow",
        "planar": "planar.planar",
    }
    assert [node.name for node in back.order] == [node.name for node in began.order]


def test_other_stages_keep_their_wires() -> None:
    assert _refusal(_loaded("corridor_ccw"), "flow=flow.dis") == (
        "--set flow=flow.dis: input 'deviation' of stage 'guard' (control.guard) reads flow.deviation, which is gone\n"
        "  a running graph keeps the wires of all other stages: choose a stage with the same outputs"
    )


def test_a_motor_output_keeps_its_guard() -> None:
    told = _refusal(_loaded("navigate_robot"), "guard=steer.random")
    assert "guard.twist" in told
    told = _refusal(_loaded("navigate_robot"), "guard=control.nonholonomic", "guard.in.steering=recovery.steering")
    assert told.startswith("graph of the run:")
    assert "the motor output 'guard.twist' does not come from a guard: nothing stops it" in told


def test_what_was_left_out_from_the_start_cannot_be_read() -> None:
    graph = _loaded("corridor_ccw").with_nodes(())
    kept = [node for node in graph.nodes if node.name not in {"sense", "sight", "heading"}]
    order = tuple(node for node in graph.order if node in kept)
    channels = {ref: channel for ref, channel in graph.channels.items() if channel.stage in {n.name for n in kept}}
    graph = Graph(graph.path, graph.about, tuple(kept), order, channels, graph.run)
    assert "robot.truth" not in graph.read
    assert _refusal(graph, "plane=plane.truth") == (
        "--set plane=plane.truth: input 'truth' of stage 'plane' (plane.truth) reads robot.truth, which 'robot' leaves "
        "out, because no stage read it when the run began\n  stop the run, and start it with this change"
    )
