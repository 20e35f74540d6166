"""The resolved graph loads again, says the same, and is the same text on every machine."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Place
from graphnav.core.graph import Graph, graph_of, load_graph, resolved_yaml

Load = Callable[..., Graph]
NOWHERE = Place("")


def meaning(graph: Graph) -> object:
    """Return what a graph does, without how it came to be."""
    nodes = [(n.name, n.use, dict(n.params), [(i.port, i.channel) for i in n.inputs], n.outputs) for n in graph.nodes]
    times = [(n.every_ms, n.deadline_ms) for n in graph.nodes]
    inputs = {ref: replace(i, place=NOWHERE) for ref, i in graph.inputs.items()}
    outputs = {ref: replace(o, place=NOWHERE) for ref, o in graph.outputs.items()}
    outside = inputs, outputs, graph.queues, times
    return graph.about, nodes, [n.name for n in graph.order], graph.channels, graph.run, outside


@pytest.mark.parametrize("sets", [(), ("plane=toy.guess",), ("plane.limits=[1, 2]", "run.record=small")])
def test_the_resolved_graph_means_the_same(load: Load, sets: tuple[str, ...]) -> None:
    graph = load() if not sets else load_default(load, *sets)
    again = load(resolved_yaml(graph))
    assert meaning(again) == meaning(graph)


def load_default(load: Load, *sets: str) -> Graph:
    return load(resolved_yaml(load()), *sets)


def test_names_options_and_sections_are_kept(load: Load) -> None:
    text = resolved_yaml(load()) + "channels: {robot.image: CAMERA}\n"
    graph = load(text + "queues: {plane.flow: {keep: all}, wheels.plane: {keep: 4}}\n")
    assert meaning(load(resolved_yaml(graph))) == meaning(graph)
    assert "  robot.image: CAMERA\n" in resolved_yaml(graph)


LIVE = """\
run: {url: "udpm://239.255.76.67:7667?ttl=1"}
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t, max_age_s: 0.25}
  base.motion: {channel: MOTION, type: toy.odometer_t}
  past.image: {log: past.lcmlog, type: graphnav_lcm.image_t}
  other.image: {log: past.lcmlog, channel: CAMERA, type: graphnav_lcm.image_t}
stages:
  flow: {use: toy.matcher, in: {image: camera.image}, deadline_ms: 12.5}
  plane: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  guard: {use: toy.guard, in: {command: wheels.twist, plane: plane.plane}, every_ms: 50}
  score: {use: toy.score, in: {plane: plane.plane, motion: base}}
outputs:
  guard.twist: {channel: BASE, type: toy.wheels_t, motor: true, max_age_s: 0.2}
  wheels.twist: {channel: WHEELS, motor: false}
  plane.plane: {channel: PLANE, type: graphnav_lcm.plane_t}
queues: {plane.flow: {keep: all}, wheels.plane: {keep: 4}}
"""


@pytest.mark.parametrize("portable_paths", [True, False])
def test_what_comes_in_and_leaves_is_kept(load: Load, tmp_path: Path, *, portable_paths: bool) -> None:
    (tmp_path / "past.lcmlog").touch()
    graph = load(LIVE)
    text = resolved_yaml(graph, portable_paths=portable_paths)
    again = load(text)
    assert resolved_yaml(again, portable_paths=True).count("past.lcmlog") == 2
    assert (str(tmp_path) in text) != portable_paths
    if portable_paths:
        assert meaning(again) == meaning(graph)
    else:
        assert again.inputs["past.image"].log == graph.inputs["past.image"].log == tmp_path / "past.lcmlog"


def test_a_stop_that_the_graph_gives_is_kept(load: Load, tmp_path: Path) -> None:
    (tmp_path / "past.lcmlog").touch()
    given = "type: graphnav_lcm.twist_t, motor: true, stop: {v_mps: 0, omega_radps: 0.0, seq: 7}"
    graph = load(LIVE.replace("type: toy.wheels_t, motor: true", given))
    assert meaning(load(resolved_yaml(graph))) == meaning(graph)
    assert graph.outputs["guard.twist"].stop == {"v_mps": 0, "omega_radps": 0.0, "seq": 7}


def test_the_text_is_the_same_wherever_the_graph_lies(toys: Catalog, tmp_path: Path) -> None:
    text = b"stages:\n  robot: {use: toy.robot, with: {map: maps/here.yaml}}\n"
    texts = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        (folder / "maps").mkdir(parents=True)
        (folder / "maps" / "here.yaml").touch()
        texts.append(resolved_yaml(graph_of(text, folder / "graph.yaml", toys)))
    assert texts[0] == texts[1]
    assert str(tmp_path) not in texts[0]


def test_without_portable_paths_the_text_loads_from_another_folder(
    toys: Catalog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here.yaml").touch()
    (tmp_path / "graph.yaml").write_text("stages:\n  robot: {use: toy.robot, with: {map: here.yaml}}\n")
    graph = load_graph(tmp_path / "graph.yaml", toys)
    run = tmp_path / "runs" / "one"
    run.mkdir(parents=True)
    (run / "graph.yaml").write_text(resolved_yaml(graph, portable_paths=False))
    monkeypatch.chdir(run)
    assert load_graph("graph.yaml", toys).node("robot").params["map"] == tmp_path / "here.yaml"


def test_what_was_rewired_and_defaulted_stands_beside_it(load: Load) -> None:
    lines = [line.strip() for line in resolved_yaml(load(resolved_yaml(load()), "plane=toy.guess")).splitlines()]
    assert "use: toy.guess  # --set plane=toy.guess" in lines
    assert "share: 0.5  # default" in lines
    assert "motion: robot.motion  # rewired: the only Motion called 'motion'" in lines
    assert "# flow: pruned, no stage reads it any more" in lines
