"""Where a picture repeats, a displacement that is not small against the period is not known."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_flow.repetition import LAYER, Repetition

from graphnav.arrays import Doubles, Floats

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair

SHAPE = (120, 160)
INNER = np.s_[16:-16, 16:-16]


def repeating(period_px: float, shift_px: float = 0.0) -> Doubles:
    """Return a pattern of the same period to both sides, moved to the right."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] * 2 * np.pi / period_px
    x = x - shift_px * 2 * np.pi / period_px
    return np.asarray(128 + 30 * np.cos(x) + 30 * np.cos(y) + 20 * np.cos(x + y + 1))


def periods_px(picture: Doubles, seed: int = 0) -> Floats:
    noisy = picture + 3 * np.random.default_rng(seed).standard_normal(SHAPE)
    return np.asarray(2**LAYER * Repetition().periods_px(cv2.pyrDown(noisy.astype(np.float32))))


def moved(like: Pair, period_px: float, shift_px: float) -> Pair:
    flow_px = np.full((*SHAPE, 2), (shift_px, 0.0))
    return type(like).of(repeating(period_px), repeating(period_px, shift_px), flow_px, 2.0, 0)


@pytest.fixture
def like(warped_pair: Callable[..., Pair]) -> Pair:
    return warped_pair(lambda x, y: (x, y))


@pytest.mark.parametrize("period_px", [7.0, 10.0, 16.0, 27.0])
def test_the_period_is_found_in_every_part_of_the_picture(period_px: float) -> None:
    assert np.abs(periods_px(repeating(period_px)) - period_px).max() <= 2.0


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("sigma_px", [0.5, 1.5, 4.0])
def test_a_texture_without_a_period_has_none(sigma_px: float, seed: int) -> None:
    texture = cv2.GaussianBlur(np.random.default_rng(seed).standard_normal(SHAPE), (0, 0), sigma_px)
    assert np.isinf(periods_px(128 + 40 * texture / texture.std(), seed)).all()


def test_a_pattern_that_comes_or_goes_is_noticed_within_three_pictures() -> None:
    layers = [cv2.pyrDown(picture.astype(np.float32)) for picture in (np.full(SHAPE, 128.0), repeating(10.0))]
    repetition = Repetition()
    for layer, shares in ((layers[0], (0, 0, 0)), (layers[1], (1 / 3, 2 / 3, 1)), (layers[0], (2 / 3, 1 / 3, 0))):
        assert [np.isfinite(repetition.periods_px(layer)).mean() for _ in shares] == pytest.approx(shares)


@pytest.mark.parametrize("period_px", [12.0, 20.0])
def test_small_displacements_are_known_and_larger_ones_are_not(period_px: float, like: Pair) -> None:
    slow, fast = (moved(like, period_px, share * period_px).made(LucasKanade()) for share in (0.15, 0.45))
    assert slow.flow.valid[INNER].mean() > 0.9
    assert fast.flow.valid[INNER].mean() < 0.1
    assert np.median(fast.deviation.deviation_px) > period_px / 2
    assert slow.deviation.known_ratio(0.5, 0.17) > 0.9
    assert fast.deviation.known_ratio(0.5, 0.17) < 0.1


def test_a_picture_that_stands_is_known_however_often_it_repeats(like: Pair) -> None:
    assert moved(like, 8.0, 0.0).made(LucasKanade()).deviation.known_ratio(0.5, 0.17) > 0.9


@pytest.mark.parametrize("shape", [(2, 2), (9, 33), (24, 24), (61, 47)])
def test_pictures_of_any_size_are_searched(shape: tuple[int, int]) -> None:
    layer = np.random.default_rng(0).standard_normal(shape).astype(np.float32)
    found = Repetition().ambiguous_px2([layer, layer], np.zeros((3, 5, 2), np.float32))
    assert found is None or found.shape == (3, 5)
