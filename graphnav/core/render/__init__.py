"""Drawings of graphs: terminal, SVG, Mermaid, Graphviz."""

from graphnav.core.render.dot import dot_of
from graphnav.core.render.mermaid import mermaid_of
from graphnav.core.render.svg import svg_of
from graphnav.core.render.text import TextDrawing, text_of

__all__ = ["TextDrawing", "dot_of", "mermaid_of", "svg_of", "text_of"]
