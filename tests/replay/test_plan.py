"""The choice of played channels and stepping stages."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, Override, graph_of, load_graph
from graphnav.replay.plan import make_plan, notices_of

SHIPPED = "corridor_ccw"


@pytest.fixture(scope="module")
def corridor() -> Graph:
    """Return a graph that ships."""
    return load_graph(SHIPPED, Catalog())


def test_by_default_sources_are_played_and_everything_else_steps(corridor: Graph) -> None:
    plan = make_plan(corridor)
    assert [node.name for node in plan.stepped.order] == [node.name for node in corridor.order]
    assert {channel.stage for channel in plan.played} == {"robot"}
    assert [c.ref for c in plan.compared if c.stage == "guard"] == ["guard.twist", "guard.state"]
    assert "robot.goal" not in {channel.ref for channel in plan.needed}
    assert plan.not_needed == ()
    assert "robot" not in {node.name for node in plan.stepped.nodes}


def test_the_middle_is_played(corridor: Graph) -> None:
    plan = make_plan(corridor, ["flow", "planar"])
    assert "flow" not in plan.stepped_names
    assert "planar" not in plan.stepped_names
    assert plan.readers_of(corridor.channels["flow.flow"]) == ["plane", "guard", "sense"]
    assert "robot.motion" not in {channel.ref for channel in plan.needed}


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("flow.flo", "--play: the graph has no channel 'flow.flo'\n  did you mean 'flow.flow'?"),
        ("plan", "--play: the graph has no channel 'plan'\n  did you mean 'plane'?"),
        ("\x1b[31m", "--play: the graph has no channel '\\x1b[31m'\n  channels are robot.image, "),
    ],
)
def test_an_unknown_channel(corridor: Graph, word: str, said: str) -> None:
    with pytest.raises(UserError) as caught:
        make_plan(corridor, [word])
    assert str(caught.value).startswith(said)


def test_something_has_to_step() -> None:
    text = b"stages: {robot: {use: world.pymunk, with: {map: maps/corridor_ccw.yaml}}}"
    graph = graph_of(text, Path("graph.yaml"), Catalog())
    with pytest.raises(UserError, match="no stage is left to step: every channel is played"):
        make_plan(graph)


def test_swaps_of_what_does_not_step_are_told() -> None:
    sets = ["robot.rate_hz=20", "flow=flow.dis", "steer.gain=2"]
    graph = load_graph(SHIPPED, Catalog(), [*map(Override.parse, sets)])
    assert [notice.partition(":")[0] for notice in notices_of(make_plan(graph, ["flow"]))] == ["robot", "flow"]
    assert [notice.partition(":")[0] for notice in notices_of(make_plan(graph))] == ["robot"]
