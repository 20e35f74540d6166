"""Checked graphs: wiring, firing order, swaps."""

from graphnav.core.graph.change import GraphChange, changed_graph, restarted_graph
from graphnav.core.graph.find import find_graph, shipped_folder, shipped_graphs, suggest_graph
from graphnav.core.graph.graph import Graph
from graphnav.core.graph.load import ReadGraph, graph_of, load_graph, outline_of_file, read_graph
from graphnav.core.graph.node import Channel, Input, InputChannel, Node, OutputChannel, Part
from graphnav.core.graph.overrides.override import Override
from graphnav.core.graph.overrides.target import Target
from graphnav.core.graph.part import part_of, part_yaml
from graphnav.core.graph.paths import beside, has_path, resolve_paths
from graphnav.core.graph.resolved import resolved_yaml
from graphnav.core.graph.schema import graph_schema
from graphnav.core.graph.wiring.channels import RESERVED
from graphnav.core.graph.wiring.stop_message import stop_fields
from graphnav.core.spec import RunOptions

__all__ = [
    "RESERVED",
    "Channel",
    "Graph",
    "GraphChange",
    "Input",
    "InputChannel",
    "Node",
    "OutputChannel",
    "Override",
    "Part",
    "ReadGraph",
    "RunOptions",
    "Target",
    "beside",
    "changed_graph",
    "find_graph",
    "graph_of",
    "graph_schema",
    "has_path",
    "load_graph",
    "outline_of_file",
    "part_of",
    "part_yaml",
    "read_graph",
    "resolve_paths",
    "resolved_yaml",
    "restarted_graph",
    "shipped_folder",
    "shipped_graphs",
    "stop_fields",
    "suggest_graph",
]
