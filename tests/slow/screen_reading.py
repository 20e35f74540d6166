"""Read a screen of the spy: its table's rates, whether it shows a picture, and the screen as an image."""

from __future__ import annotations

import re

from PIL import Image
from rich.ansi import AnsiDecoder
from rich.cells import cell_len

from graphnav.core.machine.console import Console
from graphnav.watch.spy.screen.screen_image import blank_screen, draw_cells

_PICTURE_LETTERS = "▀.:-=+*#%@"
_MIN_PICTURE_CELLS = 50


def shown_rates(shown: str) -> dict[str, float | None]:
    """Return the channels of a table and their rates, None for a dash."""
    rows = re.findall(r"^(\S+\.\S+) .*?(?:([\d.]+) Hz|-) ", shown, re.MULTILINE)
    return {channel: float(rate) if rate else None for channel, rate in rows}


def has_picture(shown: str) -> bool:
    """Whether a channel is open and shown as a picture: in half blocks, or in letters where there is no colour."""
    return "Esc back" in shown and sum(map(shown.count, _PICTURE_LETTERS)) >= _MIN_PICTURE_CELLS


def screen_picture(coloured: str, size: tuple[int, int]) -> Image.Image:
    """Draw what tmux tells of a screen and its colours."""
    console = Console(color_system="truecolor", width=size[0], force_terminal=True)
    cells = []
    for y, line in enumerate(AnsiDecoder().decode(coloured)):
        x = 0
        for segment in line.render(console):
            cells.append((x, y, segment))
            x += cell_len(segment.text)
    image = blank_screen(size)
    draw_cells(image, cells)
    return image
