"""Brightness and texture alone: what looks unlike the floor is obstacle, what looks like it is not."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from graphnav_plane.appearance import Appearance, looks

from graphnav import Image, Plane, Stamp
from graphnav.arrays import Bytes

pytestmark = pytest.mark.filterwarnings("error")


def textured(mean: float, sigma: float, seed: int, grain_px: float = 2.0) -> Bytes:
    noise = cv2.GaussianBlur(np.random.default_rng(seed).normal(0, 1, (120, 160)), (0, 0), grain_px)
    return np.asarray(np.clip(mean + sigma * noise / noise.std(), 0, 255), np.uint8)


def with_wall(wall: Bytes, seed: int = 0) -> Bytes:
    image = textured(125, 30, seed)
    image[:, :32] = wall[:, :32]
    return image


def seen(*images: Bytes, stage: Appearance | None = None) -> Plane:
    stage = stage or Appearance()
    stage.reset(0)
    return [stage.step(Image(pixels=image), Stamp(100_000 * k)) for k, image in enumerate(images)][-1]


@pytest.mark.parametrize(("mean", "sigma", "grain_px"), [(30, 10, 2.0), (230, 8, 2.0), (125, 30, 12.0)])
def test_a_wall_that_looks_different_is_obstacle(mean: float, sigma: float, grain_px: float) -> None:
    plane = seen(with_wall(textured(mean, sigma, 7, grain_px)))
    assert plane.obstacle[:, :6].mean() > 0.9
    assert plane.obstacle[:, 12:].mean() < 0.1
    assert plane.obstacle.shape == (30, 40)


def test_a_wall_painted_like_the_floor_is_not_seen() -> None:
    plane = seen(with_wall(textured(125, 30, 7)))
    assert plane.obstacle.mean() < 0.05


def test_directed_texture_is_told_from_texture_of_the_same_strength() -> None:
    streaks = cv2.GaussianBlur(np.random.default_rng(3).normal(0, 1, (120, 160)), (0, 0), sigmaX=1.0, sigmaY=12.0)
    round_ = cv2.GaussianBlur(np.random.default_rng(3).normal(0, 1, (120, 160)), (0, 0), 2.0)
    directed, even = (
        looks((125 + 30 * field / field.std()).astype(np.float32), 21)[..., 2].mean() for field in (streaks, round_)
    )
    assert directed > 0.8
    assert even < 0.4


def test_what_it_measures_of_a_ramp_is_what_a_ramp_has() -> None:
    gray = np.broadcast_to(3.0 * np.arange(40, dtype=np.float32), (30, 40)).copy()
    brightness, texture, directed = looks(gray, 5)[15, 20]
    assert brightness == pytest.approx(60.0)
    assert texture == pytest.approx(np.log(9.0 + 1.0), abs=1e-5)
    assert directed == pytest.approx(9.0 / 10.0, abs=1e-5)


def test_the_floor_is_remembered_for_some_frames_and_forgotten_after_a_gap() -> None:
    floor, wall = textured(125, 30, 0), textured(40, 30, 1)
    stage = Appearance(memory_ratio=0.9)
    stage.reset(0)
    stage.step(Image(pixels=floor), Stamp(0))
    stage.step(Image(pixels=floor), Stamp(100_000))
    assert stage.step(Image(pixels=wall), Stamp(200_000)).obstacle_ratio > 0.3
    assert stage.step(Image(pixels=wall), Stamp(10_000_000)).obstacle_ratio < 0.05


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (7, 4), (119, 158), (60, 80, 3)])
@pytest.mark.parametrize("gray", [0, 255])
def test_pictures_of_any_size_without_texture_are_floor(shape: tuple[int, ...], gray: int) -> None:
    plane = seen(np.full(shape, gray, np.uint8))
    assert plane.obstacle.shape == (-(-shape[0] // 4), -(-shape[1] // 4))
    assert plane.not_finite() is None
    assert not plane.obstacle.any()


def test_colour_is_seen_as_gray() -> None:
    gray = with_wall(textured(40, 10, 7))
    assert np.array_equal(seen(np.dstack([gray] * 3)).obstacle, seen(gray).obstacle)
