"""Colours, fonts and files that all pictures share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import AbstractPathEffect, withStroke

from graphnav import written_aside

FLOOR = "#f7f6f2"
ROBOT = "#1d3557"
CONTACT = "#d00000"
SEEN = "#2a9df4"
PATH = "viridis"

UNKNOWN = "#7a5cc9"

REPULSIVE = "#e63946"
GUIDING = "#2a9df4"
CONTROL = "#ffd23f"

QUIET = "#5c5c5c"
DPI = 120

_STYLE: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],  # comes with Matplotlib: the same letters on every machine
    "mathtext.fontset": "dejavusans",
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.linewidth": 0.8,
    "axes.edgecolor": "#404040",
    "axes.unicode_minus": True,
    "hatch.linewidth": 0.6,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.hashsalt": "graphnav",  # names of parts, the same every time
}


@contextmanager
def style() -> Iterator[None]:
    """Draw with this project's settings, whatever a user's own are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        yield


def halo(width: float = 3.0, colour: str = "white") -> list[AbstractPathEffect]:
    """Return what keeps a mark readable on any ground."""
    return [withStroke(linewidth=width, foreground=colour)]


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure with an Agg canvas, independent of pyplot."""
    figure = Figure(figsize=(width_in, height_in), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Creator": None, "Date": None},
    ".pdf": {"Creator": None, "Producer": None, "CreationDate": None},
}
"""Nothing that differs between machines and days."""


def save(figure: Figure, path: Path) -> Path:
    """Write the figure as PNG, SVG or PDF, as the suffix says; the same figure gives the same bytes."""
    with written_aside(path) as aside:
        figure.savefig(aside, format=path.suffix[1:], dpi=DPI, metadata=_METADATA[path.suffix])
    return path


def rgb(colour: str) -> tuple[int, int, int]:
    """Return ``#rrggbb`` as three numbers of 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
