"""Swaps keep wires of ports with the same name and type, rewire unambiguous ports and prune stages without readers."""

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, resolved_yaml

Load = Callable[..., Graph]

TWO_FLOWS = """\
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, with: {layers: 5}, in: {image: robot.image}}
  smooth: {use: toy.smooth, in: {flow: flow.flow}}
  plane: {use: toy.detector, with: {rule: otsu, model: a.bin}, in: {flow: smooth.flow}}
  twin: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
channels: {smooth.flow: SMOOTH, robot.image: CAMERA}
queues: {smooth.flow: {keep: all}, plane.flow: {keep: 4}}
"""


def wires(graph: Graph) -> dict[str, str]:
    """Return what every connected input reads."""
    return {f"{n.name}.{i.port.name}": i.channel.ref for n in graph.nodes for i in n.inputs if i.channel}


def names(graph: Graph) -> list[str]:
    return [node.name for node in graph.nodes]


def test_a_swap_keeps_wires_and_drops_parameters(load: Load) -> None:
    before, after = load(), load(None or TWO_FLOWS, "plane=toy.taught", "plane.model=b.bin")
    assert wires(before)["plane.flow"] == "flow.flow"
    assert wires(after)["plane.flow"] == "smooth.flow"
    assert after.node("plane").use == "toy.taught"
    assert "rule" not in after.node("plane").params


def test_a_path_of_the_same_name_is_kept_all_else_starts_from_defaults(load: Load, tmp_path: Path) -> None:
    graph = load(TWO_FLOWS, "plane=toy.guess")
    assert graph.node("plane").params == {"model": tmp_path / "a.bin", "share": 0.5}
    assert graph.notices[0] == (
        "plane: toy.detector swapped for toy.guess; defaults: share=0.5; kept: model; not carried over: rule"
    )


def test_a_swap_for_the_same_stage_changes_nothing(load: Load) -> None:
    graph = load(TWO_FLOWS, "plane=toy.detector")
    assert graph.node("plane").params == load(TWO_FLOWS).node("plane").params
    assert graph.notices[0] == "plane: it is toy.detector already"


def test_a_new_input_goes_to_the_channel_with_its_type_and_name(load: Load) -> None:
    assert wires(load(TWO_FLOWS, "plane=toy.guess"))["plane.motion"] == "robot.motion"


def test_a_new_input_goes_to_the_only_channel_of_its_type(load: Load) -> None:
    graph = load(sets_only_one_flow(), "plane=toy.from_flows")
    assert wires(graph)["plane.other"] == "flow.flow"
    assert "plane.other: wired to flow.flow, the only Flow" in graph.notices


def sets_only_one_flow() -> str:
    return (
        TWO_FLOWS.replace("  smooth: {use: toy.smooth, in: {flow: flow.flow}}\n", "")
        .replace("smooth.flow", "flow.flow")
        .partition("channels:")[0]
    )


def test_an_ambiguous_input_is_fixed_by_the_set_that_the_error_names(load: Load) -> None:
    with pytest.raises(UserError, match=r"--set plane\.in\.other=smooth\.flow"):
        load(TWO_FLOWS, "plane=toy.from_flows")
    graph = load(TWO_FLOWS, "plane=toy.from_flows", "plane.in.other=smooth.flow")
    assert wires(graph)["plane.other"] == "smooth.flow"


def test_a_new_input_is_never_wired_to_what_depends_on_the_stage(load: Load) -> None:
    graph = load(TWO_FLOWS.partition("channels:")[0], "smooth=toy.mix", "smooth.in.first=flow.flow")
    assert wires(graph)["smooth.second"] == "flow.flow"


def test_what_no_stage_reads_any_more_is_pruned_with_all_that_is_said_of_it(load: Load) -> None:
    graph = load(TWO_FLOWS, "plane=toy.guess")
    assert names(graph) == ["robot", "flow", "plane", "twin", "wheels"]
    assert "smooth: pruned, no stage reads it any more" in graph.notices
    assert {c.name for c in graph.channels.values() if c.name != c.ref} == {"CAMERA"}
    assert graph.queues == {}
    assert "queues: 'plane.flow' is gone, and what it holds" in graph.notices


def test_what_leaves_the_graph_counts_as_read(load: Load) -> None:
    graph = load(TWO_FLOWS + "outputs: {smooth.flow: {channel: SMOOTHED}}\n", "plane=toy.guess")
    assert "smooth" in names(graph)
    assert list(graph.outputs) == ["smooth.flow"]


def test_an_output_that_a_swap_takes_away_is_told(load: Load) -> None:
    graph = load(TWO_FLOWS + "outputs: {twin.plane: {channel: TWIN}}\n", "twin=toy.smooth")
    assert graph.outputs == {}
    assert "outputs: 'twin.plane' is gone: nothing leaves in its place" in graph.notices


LIVE = """\
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  base.motion: {channel: MOTION, type: graphnav_lcm.motion_t}
stages:
  robot: {use: toy.robot}
  flow: {use: toy.matcher, in: {image: robot.image}}
  plane: {use: toy.detector, in: {flow: flow.flow}}
"""


def test_an_input_is_a_candidate_for_what_a_swap_opens(load: Load) -> None:
    graph = load(LIVE.replace("robot.image", "camera.image"), "plane=toy.guess", "plane.in.motion=base")
    assert wires(graph)["plane.motion"] == "base.motion"
    with pytest.raises(UserError, match=r"2 channels have it: base\.motion, robot\.motion"):
        load(LIVE, "plane=toy.guess")


def test_an_input_that_is_set_takes_the_place_of_the_last_source(load: Load) -> None:
    graph = load(LIVE, "plane=toy.smooth", "flow.in.image=camera.image", "plane.in.flow=flow")
    assert wires(graph)["flow.image"] == "camera.image"
    assert names(graph) == ["flow", "plane"]
    assert graph.sources == ()


def test_pruning_goes_on_to_what_fed_the_pruned(load: Load) -> None:
    assert names(load(TWO_FLOWS, "plane,twin=toy.guess")) == ["robot", "plane", "twin", "wheels"]


def test_sinks_and_what_no_stage_ever_read_stay(load: Load) -> None:
    assert "twin" in names(load(TWO_FLOWS, "plane=toy.guess"))
    assert "score" in names(load())


def test_several_stages_are_swapped_at_once(load: Load) -> None:
    graph = load(TWO_FLOWS, "plane,twin=toy.guess", "plane,twin.share=0.25")
    assert [graph.node(name).params["share"] for name in ("plane", "twin")] == [0.25, 0.25]


def test_the_order_of_sets_does_not_matter(load: Load) -> None:
    sets = ["plane=toy.guess", "plane.share=0.25", "flow.layers=2"]
    assert resolved_yaml(load(TWO_FLOWS, *sets)) == resolved_yaml(load(TWO_FLOWS, *reversed(sets)))


def test_a_set_of_a_pruned_stage_is_told(load: Load) -> None:
    graph = load(TWO_FLOWS, "plane=toy.guess", "smooth.alpha=0.1")
    assert "smooth: pruned, so that '--set smooth.alpha=0.1' changes nothing" in graph.notices


def test_values_follow_the_rules_of_yaml(load: Load) -> None:
    graph = load(TWO_FLOWS, "plane.limits=[0.5, 1e-3]", "plane.strict=true", "robot.noise_px=1e-3", "run.until_s=5")
    params = graph.node("plane").params
    assert (params["limits"], params["strict"]) == ((0.5, 0.001), True)
    assert graph.node("robot").params["noise_px"] == 0.001
    assert graph.run.until_s == 5.0


def test_a_wire_is_set(load: Load) -> None:
    assert wires(load(TWO_FLOWS, "plane.in.flow=flow"))["plane.flow"] == "flow.flow"


def test_a_source_is_swapped_and_the_loop_opened(load: Load) -> None:
    graph = load(TWO_FLOWS, "wheels=toy.score")
    assert "robot.command: not connected any more, wheels.twist is gone" in graph.notices
    assert "robot.command" not in wires(graph)


def test_where_values_come_from_is_kept(load: Load) -> None:
    settings = load(TWO_FLOWS, "plane.strict=true").node("plane").settings
    assert {name: s.origin for name, s in settings.items()} == {
        "rule": "graph", "limits": "default", "model": "graph", "strict": "--set",
    }  # fmt: skip


def test_times_are_set_and_kept_through_a_swap(load: Load) -> None:
    graph = load(TWO_FLOWS, "plane.every_ms=20", "plane.deadline_ms=12.5", "plane=toy.guess")
    assert (graph.node("plane").every_ms, graph.node("plane").deadline_ms) == (20, 12.5)
    lines = [line.strip() for line in resolved_yaml(graph).splitlines()]
    assert {"every_ms: 20  # --set", "deadline_ms: 12.5  # --set"} <= set(lines)


def test_null_disconnects_an_input(load: Load) -> None:
    text = TWO_FLOWS + "about: The loop is open.\n"
    graph = load(text, "robot.in.command=null")
    assert "robot.command" not in wires(graph)
    assert "wheels.twist" not in resolved_yaml(graph)
    assert names(graph) == names(load(text))


def test_null_keeps_a_swap_from_wiring_an_input_and_may_be_said_of_an_open_one(load: Load) -> None:
    once = load(TWO_FLOWS, "robot.in.command=null", "wheels=toy.wheels")
    assert "robot.command" not in wires(once)
    assert "command" not in load(resolved_yaml(once), "robot.in.command=null").node("robot").params
