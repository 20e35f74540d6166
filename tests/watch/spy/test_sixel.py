"""Sixels: what a terminal draws of them is the picture."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from graphnav.arrays import Bools, Bytes
from graphnav.watch.spy.screen.painters.sixel_painter import SCALES, sixels

_SEQUENCE = re.compile(r'\x1bP0;1;0q"1;1;(\d+);(\d+)(.*)\x1b\\', re.DOTALL)
_TOKEN = re.compile(r"#(\d+);2;(\d+);(\d+);(\d+)|#(\d+)|!(\d+)([?-~])|([?-~])|([$-])")


def drawn(sequence: str) -> tuple[Bytes, Bools]:
    """Return what a terminal shows (rows, cols, 3), and which dots were drawn; written after the VT330 manual."""
    found = _SEQUENCE.fullmatch(sequence)
    assert found is not None
    cols, rows = int(found[1]), int(found[2])
    picture = np.zeros((rows, cols, 3), np.uint8)
    is_drawn = np.zeros((rows, cols), bool)
    registers: dict[int, tuple[int, ...]] = {}
    colour, x, y, end = (0, 0, 0), 0, 0, 0
    for token in _TOKEN.finditer(found[3]):
        assert token.start() == end, "only tokens of the manual"
        end = token.end()
        if token[1]:
            registers[int(token[1])] = tuple(round(int(part) * 2.55) for part in token.group(2, 3, 4))
        elif token[5]:
            colour = registers[int(token[5])]  # type: ignore[assignment]
        elif token[9]:
            x, y = 0, y + 6 * (token[9] == "-")
        else:
            length, dots = int(token[6] or 1), ord(token[7] or token[8]) - 63
            for row in range(6):
                if dots >> row & 1:
                    assert y + row < rows
                    assert x + length <= cols
                    picture[y + row, x : x + length] = colour
                    is_drawn[y + row, x : x + length] = True
            x += length
    assert end == len(found[3])
    return picture, is_drawn


shapes = st.tuples(st.integers(1, 20), st.integers(1, 30))


@given(arrays(np.uint8, shapes), st.sampled_from(SCALES))
def test_a_gray_picture_is_drawn_dot_for_dot(gray: Bytes, scale: int) -> None:
    shown, is_drawn = drawn(sixels(np.repeat(gray[..., None], 3, axis=2), scale))
    assert is_drawn.all(), "every dot is drawn, so nothing needs to be erased before"
    wanted = gray.repeat(scale, axis=0).repeat(scale, axis=1).astype(int)
    assert np.abs(shown.astype(int) - wanted[..., None]).max() <= 4, "64 levels, told in percent"


@given(shapes, st.sampled_from(SCALES), st.integers(0, 2**32 - 1))
def test_few_colours_are_drawn_as_they_are(shape: tuple[int, int], scale: int, seed: int) -> None:
    palette = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255], [0, 0, 0]], np.uint8)
    places = np.random.default_rng(seed).integers(0, len(palette), shape)
    shown, is_drawn = drawn(sixels(palette[places], scale))
    assert is_drawn.all()
    assert np.abs(shown[::scale, ::scale].astype(int) - palette[places]).max() <= 8


@given(arrays(np.uint8, st.tuples(st.integers(1, 12), st.integers(1, 12), st.just(3))), st.integers(2, 300))
def test_no_more_colours_than_the_terminal_has(picture: Bytes, n_colours: int) -> None:
    sequence = sixels(picture, 1, n_colours)
    assert drawn(sequence)[1].all()
    assert all(int(number) < min(n_colours, 256) for number in re.findall(r"#(\d+)", sequence))


def test_a_size_that_no_terminal_has_is_refused() -> None:
    with pytest.raises(ValueError, match="5000 columns at 1 dots"):
        sixels(np.zeros((1, 5000, 3), np.uint8))
    with pytest.raises(ValueError, match="4 dots"):
        sixels(np.zeros((1, 5, 3), np.uint8), 4)
