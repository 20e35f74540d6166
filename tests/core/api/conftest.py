"""A graph of toy stages, run through the Python door."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

import graphnav
from graphnav.core.trust import Request

STAGES = Path(__file__).parent / "door_stages.py"
GRAPH = """\
about: A sensor and what is made of it.
plugins: [door_stages.py]
run: {until_s: 1, seed: 3}
stages:
  sensor: {use: door.sensor}
  steer: {use: door.steerer, in: {flow: sensor.flow}}
  way: {use: door.way, in: {twist: sensor.twist}}
"""

RunToy = Callable[..., graphnav.Run]


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """Return the file of a graph of eleven ticks."""
    path = tmp_path / "toy.yaml"
    path.write_text(GRAPH)
    shutil.copy(STAGES, tmp_path)
    Request(tmp_path, ()).remember()
    return path


@pytest.fixture
def run_toy(graph: Path) -> RunToy:
    """Return `graphnav.run` for that graph, without pictures."""
    return partial(graphnav.run, graph, pictures=False)
