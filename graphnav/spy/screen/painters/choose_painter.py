"""Which painter a terminal gets."""

from __future__ import annotations

import os
from collections.abc import Callable

from graphnav.machine.terminal_graphics import CellSize, TerminalGraphics, cell_size_px, query_terminal
from graphnav.spy.screen.painters.block_painter import BlockPainter
from graphnav.spy.screen.painters.kitty_painter import KittyPainter
from graphnav.spy.screen.painters.painter import Painter
from graphnav.spy.screen.painters.sixel_painter import SixelPainter

_VT340_CELL_PX = (20, 10)
"""What terminals that do not say the size of their cells draw sixels for."""


def painters(choice: str) -> Callable[[], Painter]:
    """Return what makes a painter for each view.

    ``choice``: ``blocks``, ``sixel``, ``kitty``, or ``auto`` for the best that the terminal confirms.
    Asks the terminal, so it comes before anything else that reads from it.
    """
    graphics = TerminalGraphics() if choice == "blocks" else query_terminal() or TerminalGraphics()

    def cell_px() -> CellSize:
        return cell_size_px() or graphics.cell_px or _VT340_CELL_PX

    if choice == "auto":
        choice = _best(graphics)
    if choice == "kitty":
        return lambda: KittyPainter(cell_px)
    if choice == "sixel":
        return lambda: SixelPainter(cell_px, graphics.n_colours)
    return BlockPainter


def _best(graphics: TerminalGraphics) -> str:
    """Return the best that is safe: sixels of a wrong size would lie over other cells."""
    if os.environ.get("NO_COLOR"):
        return "blocks"
    if graphics.kitty:
        return "kitty"
    return "sixel" if graphics.sixel and (cell_size_px() or graphics.cell_px) else "blocks"
