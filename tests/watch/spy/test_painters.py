"""Painters: a picture lies within its view, and nothing else is touched."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual.strip import Strip

from graphnav.arrays import Bytes
from graphnav.watch.spy.screen.painters.block_painter import BlockPainter
from graphnav.watch.spy.screen.painters.kitty_painter import KittyPainter
from graphnav.watch.spy.screen.painters.painter import Painter
from graphnav.watch.spy.screen.painters.sixel_painter import SixelPainter

_TOKEN = re.compile(r"\x1b([78])|\x1b\[(\d+)([AC])|(\x1bP.*?\x1b\\)|(\x1b_G.*?\x1b\\)|( +)", re.DOTALL)
_FIRST_ROW, _FIRST_COL = 3, 40


class Screen:
    """Interpret the lines of a view as a terminal does: the blanked cells and the positions of pictures, in order."""

    def __init__(self, strips: list[Strip]) -> None:
        self.blanked: set[tuple[int, int]] = set()
        self.pictures: list[tuple[int, int]] = []
        self.after_picture: set[tuple[int, int]] = set()
        self.deleted: list[str] = []
        for y, strip in enumerate(strips):
            self._write("".join(segment.text for segment in strip), _FIRST_ROW + y, _FIRST_COL)

    def _write(self, text: str, row: int, col: int) -> None:
        saved = (0, 0)
        end = 0
        for token in _TOKEN.finditer(text):
            assert token.start() == end
            end = token.end()
            if token[1] == "7":
                saved = (row, col)
            elif token[1]:
                row, col = saved
            elif token[2]:
                row, col = (row - int(token[2]), col) if token[3] == "A" else (row, col + int(token[2]))
            elif token[6]:
                cells = {(row, col + k) for k in range(len(token[6]))}
                self.blanked |= cells
                if self.pictures:
                    self.after_picture |= cells
                col += len(token[6])
            elif token[4] or "a=T" in token[0]:
                self.pictures.append((row, col))
            elif "a=d" in token[0]:
                self.deleted.append(token[0])
        assert end == len(text)


def cell_px() -> tuple[int, int]:
    """Return an odd size of cells."""
    return 17, 9


def painted(painter: Painter, rows: int, cols: int, tall: float, wide: float) -> tuple[Bytes, list[Strip]]:
    """Return a picture that takes a part of the box, and the lines of the view."""
    box_rows, box_cols = painter.box_px(rows, cols)
    shape = (max(1, int(box_rows * tall)), max(1, int(box_cols * wide)), 3)
    picture = np.full(shape, 77, np.uint8)
    return picture, painter.paint(picture, rows, cols)


views = st.tuples(st.integers(1, 60), st.integers(1, 200))
parts = st.floats(0.01, 1)


@given(views, parts, parts)
def test_sixels_cover_their_cells_and_all_others_are_blanked(view: tuple[int, int], tall: float, wide: float) -> None:
    rows, cols = view
    painter = SixelPainter(cell_px, 256)
    picture, strips = painted(painter, rows, cols, tall, wide)
    assert len(strips) == rows
    assert all(strip.cell_length == cols for strip in strips)
    place, screen = painter.place(picture, rows, cols), Screen(strips)
    assert screen.pictures == [(_FIRST_ROW + place.row, _FIRST_COL + place.col)]
    assert not screen.after_picture, "what is written later would wipe the picture out"
    size = re.search(r'"1;1;(\d+);(\d+)', strips[-1].text)
    assert size is not None
    full_rows, full_cols = int(size[2]) // 17, int(size[1]) // 9
    covered = {
        (_FIRST_ROW + place.row + y, _FIRST_COL + place.col + x) for y in range(full_rows) for x in range(full_cols)
    }
    every = {(_FIRST_ROW + y, _FIRST_COL + x) for y in range(rows) for x in range(cols)}
    assert screen.blanked == every - covered
    assert place.row + place.rows <= rows
    assert place.col + place.cols <= cols
    assert -(-int(size[2]) // 17) == place.rows
    assert -(-int(size[1]) // 9) == place.cols


@given(views, parts, parts)
def test_kitty_gets_one_picture_and_the_last_one_is_deleted(view: tuple[int, int], tall: float, wide: float) -> None:
    rows, cols = view
    painter = KittyPainter(cell_px)
    picture, strips = painted(painter, rows, cols, tall, wide)
    place, screen = painter.place(picture, rows, cols), Screen(strips)
    assert screen.pictures == [(_FIRST_ROW + place.row, _FIRST_COL + place.col)]
    assert not screen.deleted
    assert len(screen.blanked) == rows * cols
    assert place.row + place.rows <= rows
    assert place.col + place.cols <= cols
    (first,) = re.findall(r"a=T\S*?i=(\d+)", strips[-1].text)
    again = Screen(painted(painter, rows, cols, tall, wide)[1])
    assert f"i={first}\x1b" in again.deleted[0]
    assert painter.erase()
    assert not painter.erase(), "nothing is left to delete"


@pytest.mark.parametrize("make", [lambda: SixelPainter(cell_px, 256), lambda: KittyPainter(cell_px), BlockPainter])
@given(view=views)
def test_the_box_is_bounded_and_has_the_proportions_of_the_view(
    make: type[BlockPainter], view: tuple[int, int]
) -> None:
    rows, cols = view
    painter: Painter = make()
    box_rows, box_cols = painter.box_px(rows, cols)
    assert 1 <= box_rows * box_cols <= 150_000
    assert len(painted(painter, rows, cols, 1, 1)[1]) <= rows
