"""Layers of a pyramid, doubled images and enlarged fields keep pixel i on pixel 2i."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from graphnav_flow.lucas_kanade import Enlargement
from graphnav_flow.pyramid import Doubling, Pyramid

from graphnav.arrays import Floats
from tests.plugins.flow.conftest import Pattern

INNER = np.s_[8:-8, 8:-8]


def sampled(rows: int, cols: int, step: float = 1.0, shortest: float = 8.0) -> Floats:
    y, x = np.mgrid[:rows, :cols] * step
    return Pattern(1, shortest=shortest).sample(x, y).astype(np.float32)


@pytest.mark.parametrize(("shape", "sides"), [((120, 160), [120, 60, 30, 15]), ((33, 40), [33, 17, 9]), ((1, 9), [1])])
def test_layers_are_halved_until_no_window_fits(shape: tuple[int, int], sides: list[int]) -> None:
    assert [len(layer) for layer in Pyramid(*shape, layers=3).layers] == sides


def test_a_layer_keeps_pixels_on_those_of_even_number() -> None:
    pyramid = Pyramid(64, 80, layers=1)
    pyramid.fill(np.tile(np.arange(80, dtype=np.uint8), (64, 1)))
    assert pyramid.layers[1][5, 2:-2] == pytest.approx(np.arange(4, 76, 2))


@pytest.mark.parametrize("shape", [(48, 64), (47, 63)])
def test_a_doubled_image_has_the_values_of_the_image_and_those_between(shape: tuple[int, int]) -> None:
    image = sampled(*shape)
    doubled = Doubling(*shape).double(image)
    assert doubled.shape == (2 * shape[0] - 1, 2 * shape[1] - 1)
    # A kernel of 7 taps leaves out 0.001 of 255 gray.
    assert np.abs(doubled[::2, ::2] - image)[INNER].max() < 0.3
    # At a wavelength of 8 pixels, the shortest here, a value half way comes out 0.997 times as large.
    truth = sampled(2 * shape[0] - 1, 2 * shape[1] - 1, step=0.5)
    assert np.abs(doubled - truth)[INNER].max() < 0.7


@pytest.mark.parametrize("shape", [(48, 64), (47, 63)])
def test_an_enlarged_linear_field_is_twice_as_long_and_in_place(shape: tuple[int, int]) -> None:
    y, x = np.mgrid[: (shape[0] + 1) // 2, : (shape[1] + 1) // 2].astype(np.float32)
    larger = np.empty((2, *shape), np.float32)
    Enlargement(11).enlarge([0.1 * x, 0.2 * y + 1], list(larger))
    y, x = np.mgrid[: shape[0], : shape[1]]
    assert larger[0][INNER] == pytest.approx(0.1 * x[INNER], abs=1e-4)
    assert larger[1][INNER] == pytest.approx((0.2 * y + 2)[INNER], abs=1e-4)


@pytest.mark.parametrize("smooth_px", [5, 7, 11])
def test_an_enlarged_field_is_averaged_over_the_box_of_the_larger_layer(smooth_px: int) -> None:
    field = np.random.default_rng(0).standard_normal((40, 50)).astype(np.float32)
    larger = np.empty((80, 100), np.float32)
    Enlargement(smooth_px).enlarge([field.copy()], [larger])
    box = np.full(smooth_px, 1 / smooth_px, np.float32)
    afterwards = cv2.sepFilter2D(2 * cv2.pyrUp(field), -1, box, box)
    difference = (larger - afterwards)[INNER]
    assert difference.std() < 0.15 * afterwards[INNER].std()


def test_without_smoothing_a_field_is_only_enlarged() -> None:
    field = np.random.default_rng(0).standard_normal((20, 30)).astype(np.float32)
    larger = np.empty((40, 60), np.float32)
    Enlargement(1).enlarge([field.copy()], [larger])
    assert larger == pytest.approx(2 * cv2.pyrUp(field), abs=1e-5)
