"""Drawings of graphs: terminal, SVG, Mermaid, Graphviz."""

from graphnav.core.exports import exports

__getattr__, __dir__ = exports(__name__, __file__)
