"""Render a screen as a picture, cell by cell, in Matplotlib's font."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
from PIL import Image, ImageDraw, ImageFont, ImageOps
from rich.cells import cell_len
from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from rich.terminal_theme import MONOKAI
from textual.geometry import Region
from textual.screen import Screen
from textual.widget import Widget

from graphnav.watch.spy.screen.painters.block_painter import UPPER_HALF
from graphnav.watch.spy.screen.picture_view import PictureView

_FONT = Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSansMono.ttf"
_FONT_PX = 16
_CELL_PX = (10, 20)
"""Columns and rows of pixels of a cell: one character of the font."""
_BASE_PX = 1
_BRAILLE = 0x2800
_DOTS = ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3))
"""Column and row of the dot of each bit."""

Rgb = tuple[int, int, int]


def screen_image(screen: Screen[Any]) -> Image.Image:
    """Return a screen as a picture."""
    image = blank_screen(screen.size)
    draw_cells(image, cells_of(screen))
    for view in screen.query(PictureView):
        if view.is_raw and view.display:
            _paste_picture(image, view)
    return image


def blank_screen(size: tuple[int, int]) -> Image.Image:
    """Return an empty screen of some columns and rows."""
    return Image.new("RGB", (size[0] * _CELL_PX[0], size[1] * _CELL_PX[1]), tuple(MONOKAI.background_color))


def draw_cells(image: Image.Image, cells: Iterable[tuple[int, int, Segment]]) -> None:
    """Draw the content of a screen, given by `cells_of`."""
    cols_px, rows_px = _CELL_PX
    draw = ImageDraw.Draw(image)
    font = ImageFont.truetype(str(_FONT), _FONT_PX)
    for x, y, segment in cells:
        _draw_segment(draw, font, x * cols_px, y * rows_px, segment)


def cells_of(screen: Screen[Any]) -> Iterator[tuple[int, int, Segment]]:
    """Yield column, row and segment of all visible widgets, those in upper layers last."""
    for widget in sorted(screen.walk_children(Widget), key=_is_above):
        if widget.is_container or not widget.is_on_screen or not widget.display:
            continue
        region = widget.region
        for y, strip in enumerate(widget.render_lines(Region(0, 0, region.width, region.height))):
            x = region.x
            for segment in strip:
                if segment.control:
                    continue
                yield x, region.y + y, segment
                x += cell_len(segment.text)


def _paste_picture(image: Image.Image, view: PictureView) -> None:
    """Paste a raw picture, which is not in the cells, at its place, with its aspect ratio."""
    place, picture = view.place, view.picture
    if place is None or picture is None:
        return
    cols_px, rows_px = _CELL_PX
    pixels = ImageOps.contain(Image.fromarray(picture), (place.cols * cols_px, place.rows * rows_px))
    left = (view.region.x + place.col) * cols_px + (place.cols * cols_px - pixels.width) // 2
    top = (view.region.y + place.row) * rows_px + (place.rows * rows_px - pixels.height) // 2
    image.paste(pixels, (left, top))


def _is_above(widget: Widget) -> bool:
    """Whether a widget has its own layer, as notifications do."""
    return any(isinstance(node, Widget) and node.layer != "default" for node in widget.ancestors_with_self)


def _draw_segment(draw: ImageDraw.ImageDraw, font: ImageFont.FreeTypeFont, x: int, y: int, segment: Segment) -> None:
    cols_px, rows_px = _CELL_PX
    fore, back = _colours(segment.style or Style())
    width = cell_len(segment.text) * cols_px
    if back is not None:
        draw.rectangle((x, y, x + width - 1, y + rows_px - 1), fill=back)
    if segment.text and not segment.text.strip(UPPER_HALF):
        draw.rectangle((x, y, x + width - 1, y + rows_px // 2 - 1), fill=fore)
        return
    for place, letter in enumerate(segment.text):
        left = x + cell_len(segment.text[:place]) * cols_px
        if _BRAILLE <= ord(letter) < _BRAILLE + 256:
            _draw_dots(draw, left, y, ord(letter) - _BRAILLE, fore)
        elif letter != " ":
            draw.text((left, y + _BASE_PX), letter, fill=fore, font=font)


def _draw_dots(draw: ImageDraw.ImageDraw, x: int, y: int, dots: int, colour: Rgb) -> None:
    """Draw a braille character, which the font does not have: two columns of four dots."""
    cols_px, rows_px = _CELL_PX
    for bit, (col, row) in enumerate(_DOTS):
        if dots >> bit & 1:
            left, top = x + col * cols_px // 2 + 1, y + row * rows_px // 4 + 1
            draw.rectangle((left, top, left + 2, top + 2), fill=colour)


def _colours(style: Style) -> tuple[Rgb, Rgb | None]:
    """Return the foreground and background colours; None for the screen's background."""
    fore = _rgb(style.color, is_fore=True) or MONOKAI.foreground_color
    back = _rgb(style.bgcolor, is_fore=False)
    ground = back or MONOKAI.background_color
    if style.reverse:
        fore, back = ground, fore
    elif style.dim:
        red, green, blue = ((one + other) // 2 for one, other in zip(fore, ground, strict=True))
        fore = red, green, blue
    return fore, back


def _rgb(colour: Color | None, *, is_fore: bool) -> Rgb | None:
    if colour is None or colour.is_default:
        return None
    return colour.get_truecolor(MONOKAI, foreground=is_fore)
