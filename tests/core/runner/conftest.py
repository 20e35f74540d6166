"""Graphs of the probe stages, run and recorded."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.runner.recording.summary import Summary

STAGES = Path(__file__).parent / "stages.py"
Run = Callable[..., tuple[Summary, Recording]]


@pytest.fixture
def load(tmp_path: Path) -> Callable[[str], Graph]:
    """Return a function that loads a graph from its text."""

    def load_text(text: str) -> Graph:
        path = tmp_path / "graph.yaml"
        path.write_text(textwrap.dedent(text))
        catalog = Catalog()
        catalog.add_file(STAGES)
        return load_graph(path, catalog)

    return load_text


@pytest.fixture
def run(tmp_path: Path, load: Callable[[str], Graph]) -> Run:
    """Return a function that runs a graph and gives its summary and log."""

    def run_text(text: str, name: str = "run") -> tuple[Summary, Recording]:
        graph = load(text)
        folder = tmp_path / name
        folder.mkdir()
        summary = run_recorded(graph, graph.make_stages(), folder)
        return summary, Recording(folder / RunFolder.LOG)

    return run_text
