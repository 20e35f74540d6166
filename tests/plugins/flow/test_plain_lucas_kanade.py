"""Algorithm 1 as printed, against the same algorithm written with loops over single pixels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_flow.plain_lucas_kanade import PlainLucasKanade

from graphnav.arrays import Bytes, Doubles

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair

BINOMIAL = np.outer([1, 4, 6, 4, 1], [1, 4, 6, 4, 1]) / 256


def reduced(image: Doubles) -> Doubles:
    """Return every second pixel of the image averaged by the binomial; beyond the border it is mirrored."""
    wide = np.pad(image, 2, mode="reflect")
    rows, cols = image.shape
    return np.array(
        [[(wide[r : r + 5, c : c + 5] * BINOMIAL).sum() for c in range(0, cols, 2)] for r in range(0, rows, 2)]
    )


def sampled(image: Doubles, x: float, y: float) -> Doubles:
    rows, cols = image.shape[:2]
    x, y = min(max(x, 0.0), cols - 1.0), min(max(y, 0.0), rows - 1.0)
    left, top = min(math.floor(x), cols - 2), min(math.floor(y), rows - 2)
    a, b = x - left, y - top
    upper = (1 - a) * image[top, left] + a * image[top, left + 1]
    lower = (1 - a) * image[top + 1, left] + a * image[top + 1, left + 1]
    value: Doubles = (1 - b) * upper + b * lower
    return value


def difference(line: Doubles, at: int) -> float:
    """Return the central difference, at the ends the one-sided one."""
    low, high = max(at - 1, 0), min(at + 1, len(line) - 1)
    return float((line[high] - line[low]) / (high - low))


def solved(first: Doubles, warped: Doubles, row: int, col: int, radius: int) -> Doubles:
    """Return the solution of g' d = Jw - I over the window around a pixel, by least squares."""
    rows, cols = first.shape
    places = [
        (r, c)
        for r in range(max(0, row - radius), min(rows, row + radius + 1))
        for c in range(max(0, col - radius), min(cols, col + radius + 1))
    ]
    equations = np.array([[difference(first[r], c), difference(first[:, c], r)] for r, c in places])
    found: Doubles = np.linalg.lstsq(equations, np.array([warped[r, c] - first[r, c] for r, c in places]), rcond=None)[
        0
    ]
    return found


def algorithm_1(first: Bytes, second: Bytes, layers: int, radius: int) -> Doubles:
    """Return the flow on the pixels of ``first``: where each was in ``second`` is its place less the flow."""
    pyramid = [(first.astype(float), second.astype(float))]
    for _ in range(layers):
        pyramid.append((reduced(pyramid[-1][0]), reduced(pyramid[-1][1])))
    flow = np.zeros((*pyramid[-1][0].shape, 2))
    for layer, (one, two) in reversed(list(enumerate(pyramid))):
        rows, cols = one.shape
        pixels = [(r, c) for r in range(rows) for c in range(cols)]
        if layer < layers:
            flow = np.array([2 * sampled(flow, c / 2, r / 2) for r, c in pixels]).reshape(rows, cols, 2)
        warped = np.array([sampled(two, c - flow[r, c, 0], r - flow[r, c, 1]) for r, c in pixels]).reshape(rows, cols)
        flow = flow + np.array([solved(one, warped, r, c, radius) for r, c in pixels]).reshape(rows, cols, 2)
    return flow


@pytest.mark.parametrize(("layers", "radius"), [(0, 2), (1, 2), (2, 2), (1, 1)])
def test_is_the_algorithm_as_printed(warped_pair: Callable[..., Pair], layers: int, radius: int) -> None:
    pair = warped_pair(lambda x, y: (x - 1.7 + 0.02 * y, y + 0.8), shape=(33, 38), noise=1.0)
    flow = pair.estimate(PlainLucasKanade(layers=layers, window_radius_px=radius))
    expected = algorithm_1(pair.now, pair.before, layers, radius)
    # Layers are rounded to float32, which a window with little texture magnifies.
    assert np.abs(flow.uv_px - expected).max() < 1e-3
    assert np.abs(expected).max() > 1.5


def test_every_vector_counts_where_no_rule_forbids_it(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x, y), noise=2.0)
    flow = pair.estimate(PlainLucasKanade(layers=0, margin_px=0.0, min_texture_gray2=0.0))
    stays = np.ones_like(flow.valid)
    rows, cols = stays.shape
    y, x = np.mgrid[:rows, :cols]
    came_from = np.stack([x, y], axis=-1) - flow.uv_px
    stays[((came_from < 0) | (came_from > (cols - 1, rows - 1))).any(axis=-1)] = 0
    assert (flow.valid == stays).all()
    assert stays.mean() > 0.9


def test_without_texture_there_is_no_correction() -> None:
    blank = np.full((40, 50), 90, np.uint8)
    stripes = np.tile(np.arange(0, 250, 5, dtype=np.uint8), (40, 1))
    for image in (blank, stripes):
        assert not PairOf(image, image).flow(PlainLucasKanade()).any()


class PairOf:
    """Two images, and the flow that a stage finds between them."""

    def __init__(self, before: Bytes, now: Bytes) -> None:
        self._images = before, now

    def flow(self, stage: Any) -> Doubles:
        from graphnav import Image, Stamp

        stage.reset(0)
        flows = [stage.step(Image(pixels=image), Stamp(100_000 * k)) for k, image in enumerate(self._images)]
        found: Doubles = flows[-1].uv_px
        return found


@pytest.mark.parametrize(
    "departure", [{"median_px": 5}, {"smooth_px": 11}, {"differences": "five_point"}, {"window_radius_px": 4}]
)
def test_every_refinement_alone_is_nearer_to_the_truth(
    driven_pairs: Callable[..., list[Pair]], departure: dict[str, Any]
) -> None:
    """On noisy drives each refinement helps, and all of them together in `LucasKanade` more than any."""
    pairs = driven_pairs(0.3, 6)

    def error(stage: Any) -> float:
        inner = (slice(8, -8), slice(8, -8))
        return float(np.mean([pair.error_px(pair.estimate(stage))[inner][pair.inside[inner]].mean() for pair in pairs]))

    plain, refined = error(PlainLucasKanade()), error(PlainLucasKanade(**departure))
    assert refined < plain
    assert error(LucasKanade()) < refined


def test_smoothing_is_a_box_and_the_filter_a_median(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 0.6, y), noise=2.0)
    plain = pair.estimate(PlainLucasKanade(layers=0)).uv_px
    smooth = pair.estimate(PlainLucasKanade(layers=0, smooth_px=5)).uv_px
    assert np.abs(smooth - cv2.blur(plain, (5, 5))).max() < 1e-4
    median = pair.estimate(PlainLucasKanade(layers=0, median_px=3)).uv_px
    assert (median[..., 0] == cv2.medianBlur(np.ascontiguousarray(plain[..., 0]), 3)).all()
