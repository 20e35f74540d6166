"""Processes of a graph: who lives in which, what swaps and removals leave of them, and that the log does not tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, Part, graph_of, part_of, part_yaml, resolved_yaml
from graphnav.core.runner import about_of
from tests.conftest import LOOP, TOYS

Load = Callable[[str], Graph]
DEPLOY = "deploy: {eyes: {stages: [flow, plane], restart: always, max_restarts: 5}, looks: {stages: [score]}}\n"


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Return what loads a graph that extends the loop with its processes."""
    (tmp_path / "loop.yaml").write_text(LOOP + DEPLOY)

    def loaded(text: str) -> Graph:
        path = tmp_path / "graph.yaml"
        return graph_of(f"extends: loop.yaml\n{text}".encode(), path, Catalog().add_files([TOYS]))

    return loaded


def test_the_graph_knows_its_processes(load: Load) -> None:
    assert load("").deploy == {
        "eyes": Part("eyes", ("flow", "plane"), "always", 5),
        "looks": Part("looks", ("score",)),
    }


def test_the_others_get_processes_of_their_own(load: Load) -> None:
    parts = load("").with_processes().deploy
    assert [part.stages for part in parts.values()] == [("flow", "plane"), ("score",), ("robot",), ("wheels",)]
    assert list(parts) == ["eyes", "looks", "robot", "wheels"]
    named = replace(load(""), deploy={"robot": Part("robot", ("flow",))}).with_processes().deploy
    assert named["robot_alone"].stages == ("robot",)


def test_what_is_removed_leaves_its_process(load: Load) -> None:
    graph = load("stages: {score: null}\n")
    assert list(graph.deploy) == ["eyes"]


def test_null_removes_a_process(load: Load) -> None:
    assert list(load("deploy: {looks: null}\n").deploy) == ["eyes"]


def test_the_resolved_graph_has_them_and_the_log_does_not(load: Load) -> None:
    graph = load("")
    text = resolved_yaml(graph)
    assert graph_of(text.encode(), graph.path, Catalog().add_files([TOYS])).deploy == graph.deploy
    assert about_of(graph).graph_yaml == about_of(replace(graph, deploy={})).graph_yaml
    assert "deploy" not in about_of(graph).graph_yaml


def test_stages_are_made_alone_as_they_are_among_others(load: Load) -> None:
    graph = load("channels: {flow.flow: FLOW}\n")
    part = part_of(part_yaml(graph, ("plane", "robot")), graph.path, Catalog().add_files([TOYS]))
    assert [node.name for node in part.nodes] == ["robot", "plane"]
    for node in part.nodes:
        among = graph.node(node.name)
        assert dict(node.params) == dict(among.params)
        assert [(i.port, i.channel) for i in node.inputs] == [(i.port, i.channel) for i in among.inputs]
        assert dict(node.outputs) == dict(among.outputs)
