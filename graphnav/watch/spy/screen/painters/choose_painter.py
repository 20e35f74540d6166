"""Choose the painter for a terminal."""

from __future__ import annotations

import os
from collections.abc import Callable

from graphnav.core.machine import TerminalGraphics
from graphnav.watch.spy.screen.painters.block_painter import BlockPainter
from graphnav.watch.spy.screen.painters.kitty_painter import KittyPainter
from graphnav.watch.spy.screen.painters.painter import Painter
from graphnav.watch.spy.screen.painters.sixel_painter import SixelPainter

_VT340_CELL_PX = (20, 10)
"""The cell size assumed by terminals that do not report one."""


def painters(choice: str) -> Callable[[], Painter]:
    """Return a factory of painters, one per view.

    ``choice``: ``blocks``, ``sixel``, ``kitty``, or ``auto`` for the best one that the terminal confirms.
    Queries the terminal, so call it before anything else reads from the terminal.
    """
    graphics = TerminalGraphics() if choice == "blocks" else TerminalGraphics.query() or TerminalGraphics()

    def cell_px() -> tuple[int, int]:
        return TerminalGraphics.cell_size_px() or graphics.cell_px or _VT340_CELL_PX

    if choice == "auto":
        choice = _best(graphics)
    if choice == "kitty":
        return lambda: KittyPainter(cell_px)
    if choice == "sixel":
        return lambda: SixelPainter(cell_px, graphics.n_colours)
    return BlockPainter


def _best(graphics: TerminalGraphics) -> str:
    """Return the best safe choice: sixels with a wrong cell size would cover other cells."""
    if os.environ.get("NO_COLOR"):
        return "blocks"
    if graphics.kitty:
        return "kitty"
    return "sixel" if graphics.sixel and (TerminalGraphics.cell_size_px() or graphics.cell_px) else "blocks"
