# What the rest of graphnav takes of this folder, each imported on first use.

from .announced_graph import AnnouncedGraph
from .dot import dot_of
from .geometry import Geometry, Sizes
from .mermaid import mermaid_of
from .svg import svg_of
from .text import text_of

__all__ = ["AnnouncedGraph", "Geometry", "Sizes", "dot_of", "mermaid_of", "svg_of", "text_of"]
