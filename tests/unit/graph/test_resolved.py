"""The resolved graph loads again, says the same, and is the same text on every machine."""

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.catalog import Catalog
from graphnav.graph import Graph, graph_of, load_graph, resolved_yaml

Load = Callable[..., Graph]


def meaning(graph: Graph) -> object:
    """Return what a graph does, without how it came to be."""
    nodes = [(n.name, n.use, dict(n.params), [(i.port, i.channel) for i in n.inputs], n.outputs) for n in graph.nodes]
    return graph.about, nodes, [n.name for n in graph.order], graph.channels, graph.run, graph.deploy, graph.inputs


@pytest.mark.parametrize("sets", [(), ("plane=toy.guess",), ("plane.limits=[1, 2]", "run.record=small")])
def test_the_resolved_graph_means_the_same(load: Load, sets: tuple[str, ...]) -> None:
    graph = load() if not sets else load_default(load, *sets)
    again = load(resolved_yaml(graph))
    assert meaning(again) == meaning(graph)


def load_default(load: Load, *sets: str) -> Graph:
    return load(resolved_yaml(load()), *sets)


def test_names_options_and_sections_are_kept(load: Load) -> None:
    text = resolved_yaml(load()) + "channels: {robot.image: CAMERA}\ndeploy: {a: {stages: [flow], host: jetson}}\n"
    graph = load(text + "inputs: {plane.flow: {keep: all}}\n")
    assert meaning(load(resolved_yaml(graph))) == meaning(graph)
    assert "  robot.image: CAMERA\n" in resolved_yaml(graph)


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
    assert "# flow: pruned, nobody reads it any more" in lines
