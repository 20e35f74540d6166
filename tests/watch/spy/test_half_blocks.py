"""Pictures as characters."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from graphnav.watch.spy.screen.painters.block_painter import half_blocks, run_of, shades


@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_runs_hold_the_colours_of_the_picture_to_five_bits(rows: int, cols: int, seed: int) -> None:
    picture = np.random.default_rng(seed).integers(0, 256, (rows, cols, 3), np.uint8)
    picture[:, : cols // 2] = picture[0, 0]
    lines = [[run_of(packed) for packed in line] for line in half_blocks(picture)]
    assert len(lines) == -(-rows // 2)
    for number, line in enumerate(lines):
        assert sum(run.length for run in line) == cols
        cells = [(run.above, run.below) for run in line for _ in range(run.length)]
        for col, halves in enumerate(cells):
            for row, told in zip((2 * number, min(2 * number + 1, rows - 1)), halves, strict=True):
                assert np.abs(np.array(told) - picture[row, col]).max() < 8
        assert all(one[1:] != other[1:] for one, other in itertools.pairwise(line))


def test_black_stays_black_and_white_white() -> None:
    picture = np.array([[[0] * 3, [255] * 3]], np.uint8)
    runs = [run_of(packed) for packed in half_blocks(picture)[0]]
    assert [run.above for run in runs] == [run.below for run in runs] == [(0, 0, 0), (255, 255, 255)]


def test_without_colour_there_are_shades() -> None:
    picture = np.linspace(0, 255, 20).astype(np.uint8)[None, :, None].repeat(2, 0).repeat(3, 2)
    (line,) = shades(picture)
    assert line == "  ..::--==++**##%%@@"
