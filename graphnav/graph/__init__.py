"""Checked graphs: wiring, firing order, swaps."""

from graphnav.graph.graph import Graph, RunOptions
from graphnav.graph.node import Channel, Input, Node, Setting

__all__ = ["Channel", "Graph", "Input", "Node", "RunOptions", "Setting"]
