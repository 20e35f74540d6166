"""``--set name+=family.stage`` adds a stage and wires its open inputs as a swap would."""

from collections.abc import Callable

import pytest

from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, resolved_yaml

Load = Callable[..., Graph]

GRAPH = """\
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, in: {image: robot.image}}
  smooth: {use: toy.smooth, in: {flow: flow.flow}}
  plane: {use: toy.detector, in: {flow: smooth.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
"""


def wires(graph: Graph, name: str) -> dict[str, str]:
    return {i.port.name: i.channel.ref for i in graph.node(name).inputs if i.channel}


def test_an_open_input_goes_to_the_only_channel_of_its_type(load: Load) -> None:
    graph = load(GRAPH, "judge+=toy.score")
    assert wires(graph, "judge") == {"plane": "plane.plane"}, "a sampled input stays open, as with a swap"
    assert graph.notices == (
        "judge: added, toy.score",
        "judge.plane: wired to plane.plane, the only Plane called 'plane'",
    )


def test_parameters_and_wires_apply_in_any_order(load: Load) -> None:
    sets = ["twin+=toy.detector", "twin.rule=otsu", "twin.in.flow=flow.flow", "judge+=toy.score", "judge.in.plane=twin"]
    graph = load(GRAPH, *sets)
    assert graph.node("twin").params["rule"] == "otsu"
    assert (wires(graph, "twin"), wires(graph, "judge")) == ({"flow": "flow.flow"}, {"plane": "twin.plane"})
    again = load(GRAPH, *reversed(sets))
    assert {n.name: dict(n.params) for n in again.nodes} == {n.name: dict(n.params) for n in graph.nodes}
    assert graph.notices[0] == "twin: added, toy.detector; defaults: limits=[0.0, 1.0], model=null, strict=false"


def test_nothing_else_changes(load: Load) -> None:
    plain, more = load(GRAPH), load(GRAPH, "twin+=toy.guess")
    assert more.nodes[:-1] == plain.nodes
    assert more.nodes[-1].use_note == "--set twin+=toy.guess"
    assert "use: toy.guess  # --set twin+=toy.guess" in resolved_yaml(more)


def test_several_stages_are_added_at_once(load: Load) -> None:
    graph = load(GRAPH, "one,two+=toy.guess", "one,two.share=0.25")
    assert [graph.node(name).params["share"] for name in ("one", "two")] == [0.25, 0.25]


def test_an_added_stage_may_feed_the_graph(load: Load) -> None:
    graph = load(GRAPH, "again+=toy.smooth", "again.in.flow=smooth.flow", "plane.in.flow=again.flow")
    assert [node.name for node in graph.order] == ["flow", "smooth", "again", "plane", "wheels"]


def test_it_is_never_wired_to_what_depends_on_it(load: Load) -> None:
    graph = load(GRAPH.replace("smooth.flow", "again.flow"), "again+=toy.smooth", "again.in.flow=flow.flow")
    assert wires(graph, "plane") == {"flow": "again.flow"}
    with pytest.raises(UserError, match=r"2 channels have it: flow\.flow, smooth\.flow"):
        load(
            GRAPH.replace(
                "plane: {use: toy.detector, in: {flow: smooth.flow}}",
                "plane: {use: toy.detector, in: {flow: again.flow}}",
            ),
            "again+=toy.smooth",
        )


def test_a_swap_that_takes_the_only_reader_away_spares_what_an_added_stage_reads(load: Load) -> None:
    sets = ["plane=toy.guess", "judge+=toy.mix", "judge.in.first=flow.flow", "judge.in.second=smooth.flow"]
    assert [node.name for node in load(GRAPH, *sets).nodes] == ["robot", "flow", "smooth", "plane", "wheels", "judge"]


def test_an_added_stage_may_be_swapped_too(load: Load) -> None:
    graph = load(GRAPH, "twin+=toy.detector", "twin=toy.guess", "twin.share=0.25")
    assert (graph.node("twin").use, graph.node("twin").params["share"]) == ("toy.guess", 0.25)
    assert graph.notices[0] == "twin: added, toy.guess; defaults: model=null"


def test_a_source_may_be_added(load: Load) -> None:
    graph = load(GRAPH, "camera+=toy.robot")
    assert [source.name for source in graph.sources] == ["robot", "camera"]
