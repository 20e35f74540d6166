# What the rest of graphnav takes of this folder, each imported on first use.

from .boxes import Box, InPort, Kind, OutPort
from .dot import dot_of
from .geometry import PlacedBox, PlacedWire, Sizes, geometry_of
from .mermaid import mermaid_of
from .svg import svg_of
from .text import text_of

__all__ = [
    "Box",
    "InPort",
    "Kind",
    "OutPort",
    "PlacedBox",
    "PlacedWire",
    "Sizes",
    "dot_of",
    "geometry_of",
    "mermaid_of",
    "svg_of",
    "text_of",
]
