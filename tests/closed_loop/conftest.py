"""Shipped graphs, run into a scratch folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override, load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.trust import Trust

Drive = Callable[..., tuple[Summary, Recording]]


@pytest.fixture
def drive(tmp_path: Path) -> Drive:
    """Return a function that runs a shipped graph with a seed and swaps, and gives its summary and full log."""

    def run(name: str, seed: int, *sets: str) -> tuple[Summary, Recording]:
        everything = () if any(text.startswith("run.record=") for text in sets) else ("run.record=all",)
        graph = load_graph(
            name, Catalog(Trust(runs_all=True)), [*map(Override.parse, (*everything, *sets, f"run.seed={seed}"))]
        )
        folder = tmp_path / f"{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        summary = run_recorded(graph, graph.make_stages(), folder)
        return summary, Recording(folder / RunFolder.LOG)

    return run


@pytest.fixture(autouse=True)
def _one_pool(study_workers: None) -> None:
    """Start no worker of studies twice."""
