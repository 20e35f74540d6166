"""A catalog of toy stages, shared by the tests of graphs."""

from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, graph_of, parse_override

TOYS = Path(__file__).parent.parent / "errors" / "stages.py"

LOOP = """\
about: A toy that sees noise.
run: {until_s: 1, seed: 3}
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, in: {image: robot.image}}
  plane: {use: toy.detector, with: {rule: otsu}, in: {flow: flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  score: {use: toy.score, in: {plane: plane.plane, motion: robot.motion}}
"""


@pytest.fixture(scope="session")
def toys() -> Catalog:
    """Return a catalog with the family ``toy``."""
    catalog = Catalog()
    catalog.add_file(TOYS)
    return catalog


@pytest.fixture
def load(toys: Catalog, tmp_path: Path) -> Callable[..., Graph]:
    """Return a function that loads the text of a graph, as if it stood in an empty folder."""

    def loaded(text: str = LOOP, *sets: str) -> Graph:
        return graph_of(text.encode(), tmp_path / "graph.yaml", toys, [*map(parse_override, sets)], "graph.yaml")

    return loaded
