"""One rule of validity for all estimators and for the truth."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_flow.truth import Truth
from graphnav_flow.validity import Inside, Texture, min_eigenvalue

import graphnav
from graphnav import Stage

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair


def uniform(u: float, v: float, shape: tuple[int, int] = (20, 30)) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    return np.full((*shape, 2), (u, v), np.float32)


def test_the_margin_holds_for_the_pixel_and_for_its_source() -> None:
    valid = Inside(20, 30, 3.0).mark(uniform(5.0, 0.0))
    rows, cols = np.nonzero(valid)
    assert (rows.min(), rows.max()) == (3, 16)
    assert (cols.min(), cols.max()) == (8, 26)


def test_what_moves_up_came_from_below() -> None:
    valid = Inside(20, 30, 0.0).mark(uniform(0.0, -4.0))
    assert valid[:16].all()
    assert not valid[16:].any()


@pytest.mark.parametrize("margin_px", [0.0, 0.5, 1.0, 9.0, 10.0, 15.0, 1000.0])
def test_the_margin_counts_pixel_centres(margin_px: float) -> None:
    at = np.minimum(np.arange(30), 29 - np.arange(30))
    down = np.minimum(np.arange(20), 19 - np.arange(20))
    expected = (at >= margin_px)[None] & (down >= margin_px)[:, None]
    assert np.array_equal(Inside(20, 30, margin_px).mark(uniform(0.0, 0.0)), expected)


def test_vectors_that_are_not_finite_are_not_valid() -> None:
    flow = uniform(0.0, 0.0)
    flow[8, 10, 0], flow[9, 11, 1], flow[10, 12, 0] = np.nan, np.inf, -np.inf
    invalid = ~Inside(20, 30, 2.0).mark(flow)[2:-2, 2:-2]
    assert list(zip(*np.nonzero(invalid), strict=True)) == [(6, 8), (7, 9), (8, 10)]


def test_the_smaller_eigenvalue_is_that_of_numpy() -> None:
    rng = np.random.default_rng(0)
    root = rng.standard_normal((5, 7, 2, 2)).astype(np.float32)
    matrices = root @ np.swapaxes(root, -1, -2)
    smaller = min_eigenvalue(*(np.ascontiguousarray(matrices[..., i, j]) for i, j in ((0, 0), (0, 1), (1, 1))))
    assert smaller == pytest.approx(np.linalg.eigvalsh(matrices)[..., 0], abs=1e-5)


@pytest.mark.parametrize("shape", [(120, 160), (119, 161), (7, 5), (3, 2), (1, 1)])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_texture_is_the_eigenvalue_of_block_means(shape: tuple[int, int], dtype: type) -> None:
    gray = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 256, shape, np.uint8), (0, 0), 1.5)
    gu, gv = (cv2.Sobel(gray.astype(float), cv2.CV_64F, *order, ksize=1) / 2 for order in ((1, 0), (0, 1)))
    blocks = (max(1, shape[1] // 4), max(1, shape[0] // 4))
    means = [
        cv2.blur(cv2.resize(product, blocks, interpolation=cv2.INTER_AREA), (3, 3))
        for product in (gu * gu, gu * gv, gu * gv, gv * gv)
    ]
    smaller = np.linalg.eigvalsh(np.stack(means, axis=-1).reshape(*means[0].shape, 2, 2))[..., 0]
    measured = Texture(*shape).measure(gray.astype(dtype))
    assert measured == pytest.approx(cv2.resize(smaller, shape[::-1]), abs=0.01)


@pytest.mark.parametrize("threshold_gray2", [0.0, 3.0, 1e6])
def test_what_has_too_little_texture_is_cleared(threshold_gray2: float) -> None:
    gray = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 256, (60, 80), np.uint8), (0, 0), 2)
    texture, mask = Texture(60, 80), np.random.default_rng(1).random((60, 80)) < 0.5
    expected = mask & (texture.measure(gray) >= threshold_gray2)
    texture.clear_below(threshold_gray2, gray, mask)
    assert np.array_equal(mask, expected)


def test_texture_of_noise_is_half_its_variance() -> None:
    noise = np.rint(128 + 6 * np.random.default_rng(0).standard_normal((120, 160))).astype(np.uint8)
    assert Texture(120, 160).measure(noise).mean() == pytest.approx(18, rel=0.2)


@pytest.mark.parametrize("estimator", [LucasKanade, Farneback, Dis])
def test_estimators_and_truth_agree_on_what_came_from_inside(
    estimator: type[Stage], warped_pair: Callable[..., Pair]
) -> None:
    pair = warped_pair(lambda x, y: (x + 6.0, y - 4.0))
    shape = pair.now.shape
    truth = graphnav.Truth(
        obstacle=np.zeros(shape, np.uint8),
        depth_m=np.ones(shape, np.float32),
        flow_px=pair.flow_px.astype(np.float32),
        interval_us=100_000,
    )
    stage = Truth()
    stage.reset(0)
    oracle = stage.step(truth)
    assert oracle.interval_us == 100_000
    assert np.array_equal(oracle.uv_px, truth.flow_px)
    estimated = pair.estimate(estimator())
    sure = cv2.erode(oracle.valid, np.ones((3, 3), np.uint8))
    possible = cv2.dilate(oracle.valid, np.ones((3, 3), np.uint8))
    assert np.mean(estimated.valid[sure > 0]) > 0.99
    assert not estimated.valid[possible == 0].any()


def test_true_flow_is_not_valid_above_the_horizon() -> None:
    depth_m = np.ones((48, 64), np.float32)
    depth_m[:20] = np.inf
    flow_px = np.zeros((48, 64, 2), np.float32)
    truth = graphnav.Truth(obstacle=np.zeros((48, 64), np.uint8), depth_m=depth_m, flow_px=flow_px, interval_us=1)
    stage = Truth(margin_px=6.0)
    stage.reset(0)
    valid = stage.step(truth).valid
    assert not valid[:20].any()
    assert valid[20:-6, 6:-6].all()


def test_valid_vectors_err_less_than_the_others(driven_pairs: Callable[..., list[Pair]]) -> None:
    stage = LucasKanade()
    for pair in driven_pairs(1.5, 4):
        flow = pair.estimate(stage)
        error = pair.error_px(flow)
        assert error[flow.valid > 0].mean() < 0.25 * error[flow.valid == 0].mean()
