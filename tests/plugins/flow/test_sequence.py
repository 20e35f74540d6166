"""Estimators see one image after the other: what they keep, what they refuse, what they make of odd images."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
from graphnav_flow.dis import Dis
from graphnav_flow.farneback import Farneback
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_flow.plain_lucas_kanade import PlainLucasKanade
from testbed.flows import flow_from

from graphnav import Image, Stage, Stamp

if TYPE_CHECKING:
    from tests.plugins.flow.conftest import Pair

ESTIMATORS = [LucasKanade, PlainLucasKanade, Farneback, Dis]


def started(estimator: Callable[..., Any], **parameters: Any) -> Any:
    stage = estimator(**parameters)
    stage.reset(0)
    return stage


def noise_image(shape: tuple[int, ...], seed: int = 0) -> Image:
    return Image(pixels=np.random.default_rng(seed).integers(0, 256, shape, np.uint8))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_the_first_image_gives_no_flow_and_the_second_covers_the_time_between(estimator: type[Stage]) -> None:
    stage = started(estimator)
    assert flow_from(stage, noise_image((60, 80)), Stamp(1_000_000)) is None
    flow = flow_from(stage, noise_image((60, 80)), Stamp(1_050_000))
    assert flow.interval_us == 50_000
    assert flow.step_px == 1
    assert flow.uv_px.shape == (60, 80, 2)
    assert flow.uv_px.dtype == np.float32
    assert flow.valid.shape == (60, 80)
    assert flow.valid.dtype == np.uint8
    assert set(np.unique(flow.valid)) <= {0, 1}


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_reset_forgets_everything(estimator: type[Stage], warped_pair: Callable[..., Pair]) -> None:
    stage, pair = started(estimator), warped_pair(lambda x, y: (x + 1.3, y))
    other = warped_pair(lambda x, y: (x, y), shape=(60, 90), seed=5)
    first = pair.estimate(stage)
    other.estimate(stage)
    again = pair.estimate(stage)
    assert np.array_equal(first.uv_px, again.uv_px)
    assert np.array_equal(first.valid, again.valid)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("gap_us", [310_000, 0, -50_000, 3_600_000_000])
def test_after_a_gap_and_after_a_stamp_that_does_not_advance_flow_restarts(
    estimator: type[Stage], gap_us: int, warped_pair: Callable[..., Pair]
) -> None:
    pair, stage = warped_pair(lambda x, y: (x + 1.3, y)), started(estimator)
    for frame in range(4):
        flow_from(stage, noise_image((120, 160), frame), Stamp(100_000 * frame))
    after_us = 300_000 + gap_us
    assert flow_from(stage, Image(pixels=pair.before), Stamp(after_us)) is None
    flow = flow_from(stage, Image(pixels=pair.now), Stamp(after_us + 100_000))
    assert flow.interval_us == 100_000
    assert np.array_equal(flow.uv_px, pair.estimate(started(estimator)).uv_px)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_flow_goes_on_over_a_frame_or_two_that_were_lost(estimator: type[Stage]) -> None:
    stage = started(estimator)
    for frame in range(4):
        flow_from(stage, noise_image((60, 80), frame), Stamp(100_000 * frame))
    assert flow_from(stage, noise_image((60, 80)), Stamp(600_000)).interval_us == 300_000


def test_only_the_last_two_images_matter(warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 1.3, y))
    stage = started(LucasKanade)
    for stamp, image in enumerate([noise_image((120, 160)), noise_image((120, 160), 1), Image(pixels=pair.before)]):
        flow_from(stage, image, Stamp(stamp))
    flow = flow_from(stage, Image(pixels=pair.now), Stamp(3))
    assert np.array_equal(flow.uv_px, pair.estimate(LucasKanade()).uv_px)


def test_a_published_flow_is_not_written_again(warped_pair: Callable[..., Pair]) -> None:
    pair, stage = warped_pair(lambda x, y: (x + 1.3, y)), started(LucasKanade)
    flow_from(stage, Image(pixels=pair.before), Stamp(0))
    flow = flow_from(stage, Image(pixels=pair.now), Stamp(1))
    uv_px, valid = flow.uv_px.copy(), flow.valid.copy()
    flow_from(stage, noise_image((120, 160)), Stamp(2))
    assert np.array_equal(flow.uv_px, uv_px)
    assert np.array_equal(flow.valid, valid)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_received_images_are_read_only_and_stay_as_they_are(estimator: type[Stage]) -> None:
    stage = started(estimator)
    for stamp in range(3):
        image = noise_image((60, 80), stamp)
        kept = image.pixels.copy()
        image.pixels.flags.writeable = False
        flow_from(stage, image, Stamp(stamp))
        assert np.array_equal(image.pixels, kept)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_change_of_size_is_refused(estimator: type[Stage]) -> None:
    stage = started(estimator)
    flow_from(stage, noise_image((60, 80)), Stamp(0))
    with pytest.raises(ValueError, match=r"^the image is 90x60, but the ones before were 80x60$"):
        flow_from(stage, noise_image((60, 90)), Stamp(1))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_colour_is_reduced_to_brightness(estimator: type[Stage], warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 1.3, y))
    stage = started(estimator)
    for stamp, gray in enumerate((pair.before, pair.now)):
        flow = flow_from(stage, Image(pixels=cv2.cvtColor(gray, cv2.COLOR_GRAY2RGB)), Stamp(stamp))
    assert np.abs(flow.uv_px - pair.estimate(estimator()).uv_px).max() < 1e-3


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("gray", [0, 100, 255])
def test_a_flat_image_gives_finite_flow_that_is_nowhere_valid(estimator: type[Stage], gray: int) -> None:
    stage, image = started(estimator), Image(pixels=np.full((60, 80), gray, np.uint8))
    flow_from(stage, image, Stamp(0))
    flow = flow_from(stage, image, Stamp(1))
    assert np.isfinite(flow.uv_px).all()
    assert not flow.valid.any()


def test_noise_without_texture_is_not_valid() -> None:
    rng, stage = np.random.default_rng(3), started(LucasKanade)
    for stamp in range(2):
        pixels = np.rint(128 + 2 * rng.standard_normal((120, 160))).astype(np.uint8)
        flow = flow_from(stage, Image(pixels=pixels), Stamp(stamp))
    assert flow.valid.mean() < 0.01


def test_stripes_have_texture_in_one_direction_only_and_are_not_valid() -> None:
    stage = started(LucasKanade)
    for stamp in range(2):
        row = 128 + 60 * np.sin(np.arange(160) / 3 + stamp / 2)
        flow = flow_from(stage, Image(pixels=np.tile(row.astype(np.uint8), (120, 1))), Stamp(stamp))
    assert not flow.valid.any()


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (8, 8), (9, 7), (16, 16), (17, 40), (8, 200), (119, 161)])
def test_any_size_has_a_finite_flow(shape: tuple[int, int]) -> None:
    stage = started(LucasKanade)
    flow_from(stage, noise_image(shape, 0), Stamp(0))
    flow = flow_from(stage, noise_image(shape, 1), Stamp(1))
    assert flow.uv_px.shape == (*shape, 2)
    assert flow.valid.shape == shape
    assert np.isfinite(flow.uv_px).all()


@pytest.mark.parametrize("shape", [(119, 161), (97, 33), (120, 159)])
def test_odd_sizes_are_as_exact(shape: tuple[int, int], warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x + 3.3, y - 2.6), shape=shape)
    flow = pair.estimate(LucasKanade())
    assert pair.error_px(flow)[flow.valid > 0].mean() < 0.032


@pytest.mark.parametrize("shape", [(31, 200), (200, 31), (8, 8)])
def test_dis_refuses_what_opencv_cannot_do(shape: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match=rf"^the image is {shape[1]}x{shape[0]}, but each side must have at least 32"):
        started(Dis).step(noise_image(shape), Stamp(0))


@pytest.mark.parametrize("preset", ["ultrafast", "fast", "medium"])
def test_all_presets_of_dis_follow_a_shift(preset: str, warped_pair: Callable[..., Pair]) -> None:
    pair = warped_pair(lambda x, y: (x - 3.0, y + 2.0))
    flow = pair.estimate(started(Dis, preset=preset))
    assert pair.error_px(flow)[flow.valid > 0].mean() < 0.3
