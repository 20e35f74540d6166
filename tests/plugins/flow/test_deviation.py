"""The predicted deviation of a vector is that of its error, and what cannot be known is not valid."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from graphnav_flow.deviation import STEP_PX
from graphnav_flow.lucas_kanade import LucasKanade

from graphnav.arrays import Bytes, Doubles

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair

SHAPE = (120, 160)


def pair_of(before: Doubles, now: Doubles, like: Pair, noise: float, flow_px: tuple[float, float]) -> Pair:
    return type(like).of(before, now, np.full((*before.shape, 2), flow_px), noise, 0)


@pytest.fixture
def like(warped_pair: Callable[..., Pair]) -> Pair:
    return warped_pair(lambda x, y: (x + 1.3, y - 0.7))


@pytest.mark.parametrize("contrast", [1.0, 0.3, 0.1])
@pytest.mark.parametrize("noise", [2.0, 6.0])
def test_two_thirds_of_the_errors_are_within_it_and_nearly_all_within_twice_of_it(
    contrast: float, noise: float, like: Pair
) -> None:
    before, now = (np.asarray(128 + contrast * (np.asarray(one, float) - 128)) for one in (like.before, like.now))
    pair = pair_of(before, now, like, noise, (-1.3, 0.7))
    flow, deviation = pair.made(LucasKanade())
    off = pair.error_px(flow)[::STEP_PX, ::STEP_PX] / deviation.deviation_px
    inner = off[6:-6, 6:-6]
    assert 0.35 < (inner < 1).mean() <= 1
    assert (inner < 2).mean() > 0.8


@pytest.mark.parametrize("sigma_px", [0.0, 1.0, 2.5])
def test_a_picture_that_is_new_in_every_frame_is_not_valid(sigma_px: float, like: Pair) -> None:
    rng = np.random.default_rng(0)

    def new() -> Doubles:
        noise = rng.standard_normal(SHAPE)
        smooth = cv2.GaussianBlur(noise, (0, 0), sigma_px) if sigma_px else noise
        return np.asarray(128 + 40 * smooth / smooth.std())

    assert pair_of(new(), new(), like, 0.0, (0.0, 0.0)).estimate(LucasKanade()).valid.mean() < 0.02


@pytest.mark.parametrize("noise", [0.0, 0.5, 2.0, 8.0])
def test_a_blank_picture_is_not_valid_however_noisy(noise: float, like: Pair) -> None:
    blank = np.full(SHAPE, 128.0)
    flow = pair_of(blank, blank, like, noise, (0.0, 0.0)).estimate(LucasKanade())
    assert np.isfinite(flow.uv_px).all()
    assert flow.valid.mean() < 0.06


def test_texture_a_tenth_as_strong_as_usual_is_valid(like: Pair) -> None:
    faint: list[Bytes | Doubles] = [128 + 0.1 * (np.asarray(one, float) - 128) for one in (like.before, like.now)]
    flow = pair_of(np.asarray(faint[0]), np.asarray(faint[1]), like, 2.0, (-1.3, 0.7)).estimate(LucasKanade())
    assert flow.valid[12:-12, 12:-12].mean() > 0.9


def test_an_edge_alone_is_not_valid(like: Pair) -> None:
    edge = np.where(np.arange(160) < 80, 90.0, 170.0)[None].repeat(120, axis=0)
    flow = pair_of(edge, edge, like, 2.0, (0.0, 0.0)).estimate(LucasKanade())
    assert flow.valid.mean() < 0.2


@pytest.mark.parametrize("shape", [(8, 8), (9, 33), (61, 47), (120, 160)])
def test_pictures_of_any_size_have_one(shape: tuple[int, int], warped_pair: Callable[..., Pair]) -> None:
    flow = warped_pair(lambda x, y: (x, y), shape=shape).estimate(LucasKanade(margin_px=0.0))
    assert flow.valid.shape == shape
