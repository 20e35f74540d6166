"""The page of graph files: their keys, as they are declared, and the graphs that ship."""

from __future__ import annotations

from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_graphs
from graphnav.core.spec import GRAPH
from reference_pages.markdown import bullets, code


def graphs_page() -> str:
    """Return the page."""
    shipped = "## Graphs that ship\n\nRun them by name: `graphnav run corridor_ccw`. The files are in "
    shipped += "[graphs/graphnav_graphs](../../graphs/graphnav_graphs/corridor_ccw.yaml)."
    return "\n\n".join([GRAPH.reference().rstrip(), shipped, *map(_shipped, shipped_graphs())]) + "\n"


def _shipped(name: str) -> str:
    graph = load_graph(shipped_graphs()[name], Catalog())
    stages = (f"`{node.name}`: {code(node.use)}" for node in graph.nodes)
    return f"### {name}\n\n{graph.about}\n\n{bullets(stages)}"
