"""Lucas-Kanade with local normalization follows motion through changes of light, and its formulas hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_flow.normalization import CONTRAST_GRAY, Normalization
from testbed.flows import flow_from

from graphnav import Image, Stamp

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair

SIGMA_PX = 4.0


def normalized(image: np.ndarray, sigma_px: float = SIGMA_PX) -> np.ndarray:
    layer = image.astype(np.float32)
    Normalization([layer.shape], sigma_px).normalize([layer])
    return layer


def lit(pair: Pair, ratio: float) -> Pair:
    """Return the pair with the later frame brighter or darker, and no gray level cut off."""
    now = np.rint(128 + (pair.now - 128.0) / 2) * ratio
    before = np.rint(128 + (pair.before - 128.0) / 2)
    assert now.min() >= 0
    assert now.max() <= 255
    return type(pair)(before.astype(np.uint8), np.rint(now).astype(np.uint8), pair.flow_px, pair.inside)


def error_of_valid_px(pair: Pair, stage: LucasKanade) -> float:
    flow = pair.estimate(stage)
    return float(pair.error_px(flow)[flow.valid > 0].mean())


def textured(shape: tuple[int, int] = (60, 80)) -> np.ndarray:
    noise = np.random.default_rng(0).integers(0, 256, shape).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(noise, (0, 0), 1.5))


@pytest.mark.parametrize("ratio", [0.7, 0.95, 1.05, 1.3])
def test_a_change_of_brightness_is_not_motion(ratio: float, warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 2.3, y - 1.4))
    changed = lit(pair, ratio)
    assert error_of_valid_px(changed, LucasKanade(normalize_sigma_px=SIGMA_PX)) < 0.05
    assert error_of_valid_px(changed, LucasKanade(normalize_sigma_px=None, max_deviation_px=100.0)) > 0.2


@pytest.mark.parametrize("shift", [(0.0, 0.0), (1.37, -0.61), (-3.0, 2.0), (11.3, -7.2)])
def test_in_steady_light_a_shift_is_found_to_a_twentieth_of_a_pixel(
    shift: tuple[float, float], warped_pair: Callable[..., Pair]
) -> None:
    pair = warped_pair(lambda x, y: (x + shift[0], y + shift[1]))
    assert error_of_valid_px(pair, LucasKanade(normalize_sigma_px=SIGMA_PX)) < 0.05


def test_large_displacements_are_still_followed(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 14.0, y))
    assert error_of_valid_px(pair, LucasKanade(normalize_sigma_px=SIGMA_PX)) < 0.05


def test_noise_is_not_valid_at_any_contrast() -> None:
    rng = np.random.default_rng(3)
    stage = LucasKanade(normalize_sigma_px=SIGMA_PX)
    stage.reset(0)
    for stamp in range(2):
        pixels = np.rint(128 + 2 * rng.standard_normal((120, 160))).astype(np.uint8)
        flow = flow_from(stage, Image(pixels=pixels), Stamp(100_000 * stamp))
    assert flow is not None
    assert flow.valid.mean() < 0.01


@pytest.mark.parametrize("gray", [0, 100, 255])
def test_a_flat_image_stays_flat(gray: int) -> None:
    # Means of equal values are exact to a few units of float32 in 255; the gain is 40 / 0.5.
    assert np.abs(normalized(np.full((60, 80), gray))).max() < 1e-1


def test_noise_on_a_blank_wall_is_not_raised_to_the_contrast_of_texture() -> None:
    image = textured((60, 160)) * 3
    image[:, 80:] = 128 + np.random.default_rng(0).standard_normal((60, 80))
    result = normalized(image)
    assert result[:, 100:].std() < 0.05 * result[:, :60].std()


def test_a_blank_layer_is_not_raised_to_the_contrast_of_the_base() -> None:
    y, x = np.mgrid[:60, :80]
    base = (128 + 40 * np.sin(2 * np.pi * x / 3) * np.sin(2 * np.pi * y / 3)).astype(np.float32)
    above = cv2.pyrDown(base)
    ratio = above.std() / base.std()
    Normalization([base.shape, above.shape], SIGMA_PX).normalize([base, above])
    assert ratio < 0.2
    assert above.std() < 1.6 * ratio * base.std()


def test_texture_gets_the_fixed_contrast() -> None:
    assert normalized(textured() * 3).std() == pytest.approx(CONTRAST_GRAY / 2**0.5, rel=0.1)


@pytest.mark.parametrize(("gain", "offset_gray"), [(1.0, 40.0), (1.0, -40.0), (2.0, 0.0)])
def test_gain_and_offset_of_the_light_cancel(gain: float, offset_gray: float) -> None:
    image = textured()
    # The floor under the contrast, 0.5 gray, counts less where the contrast, 10 gray and more, is doubled.
    tolerance_gray = 1e-2 if gain == 1 else 0.01 * CONTRAST_GRAY
    assert np.abs(normalized(gain * image + offset_gray) - normalized(image)).max() < tolerance_gray


def test_the_window_is_nearly_a_gaussian_of_full_resolution() -> None:
    image = textured() * 3
    mean = cv2.GaussianBlur(image, (0, 0), SIGMA_PX, borderType=cv2.BORDER_REFLECT)
    off = image - mean
    contrast = np.sqrt(
        cv2.GaussianBlur(off * off, (0, 0), SIGMA_PX, borderType=cv2.BORDER_REFLECT) + (off * off).mean() + 0.25
    )
    # Half the resolution aliases a little of the texture into the means.
    assert np.abs(normalized(image) - CONTRAST_GRAY * off / contrast).mean() < 0.03 * CONTRAST_GRAY


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (8, 200), (17, 40), (119, 161)])
@pytest.mark.parametrize("sigma_px", [0.1, 4.0, 30.0])
def test_any_size_and_window_gives_finite_values(shape: tuple[int, int], sigma_px: float) -> None:
    image = np.random.default_rng(0).integers(0, 256, shape)
    assert np.isfinite(normalized(image, sigma_px)).all()
