"""Residuals of the last frames move along with the picture and steady the result."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.affine import Affine
from graphnav_plane.detector import Detector
from graphnav_plane.homography import Homography
from graphnav_plane.ica import Ica
from graphnav_plane.memory import Memory
from graphnav_plane.residual import Residual

from graphnav import Plane, Stamp

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scene, Scenes

ALL = np.ones((8, 10), np.bool_)
STILL = np.zeros((8, 10, 2), np.float32)
DETECTORS = [Ica, Affine, Homography, Residual]


def seen(detector: Detector, scene: Scene, stamp: Stamp) -> Plane:
    if isinstance(detector, Affine | Homography):
        return detector.step(scene.flow, stamp)
    assert isinstance(detector, Ica | Residual)
    if isinstance(detector, Ica):
        return detector.step(scene.flow, scene.planar, stamp).plane
    return detector.step(scene.flow, scene.planar, stamp)


def field(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(8, 10, 2)).astype(np.float32)


def test_a_share_of_zero_remembers_nothing() -> None:
    memory = Memory(0.0)
    memory.mean(field(0), ALL, STILL)
    assert np.array_equal(memory.mean(field(1), ALL, STILL), field(1))


def test_a_still_picture_gives_the_running_mean() -> None:
    memory = Memory(0.75)
    expected = field(0)
    assert np.array_equal(memory.mean(field(0), ALL, STILL), expected)
    for seed in (1, 2):
        expected = 0.25 * field(seed) + 0.75 * expected
        assert memory.mean(field(seed), ALL, STILL) == pytest.approx(expected, abs=1e-6)


def test_it_follows_the_flow() -> None:
    memory = Memory(0.5)
    moved = np.broadcast_to(np.array([2.0, 1.0], np.float32), (8, 10, 2))
    memory.mean(field(0), ALL, STILL)
    mean = memory.mean(field(1), ALL, moved)
    assert mean[1:, 2:] == pytest.approx((field(1)[1:, 2:] + field(0)[:-1, :-2]) / 2, abs=1e-6)


def test_what_comes_from_outside_or_from_unknown_cells_stands_for_itself() -> None:
    memory = Memory(0.5)
    known = ALL.copy()
    known[3, 4] = False
    memory.mean(field(0), known, STILL)
    mean = memory.mean(field(1), ALL, np.broadcast_to(np.array([2.0, 0.0], np.float32), (8, 10, 2)))
    assert np.array_equal(mean[:, :2], field(1)[:, :2])
    assert np.array_equal(mean[3, 6], field(1)[3, 6])


def test_cells_that_are_not_valid_are_zero_and_are_not_remembered() -> None:
    memory = Memory(0.5)
    known = ALL.copy()
    known[3, 4] = False
    wild = field(0)
    wild[3, 4] = 1e9
    assert not memory.mean(wild, known, STILL)[3, 4].any()
    assert np.abs(memory.mean(field(1), ALL, STILL)).max() < 10


def test_another_grid_restarts() -> None:
    memory = Memory(0.5)
    memory.mean(np.ones((4, 4, 2), np.float32), np.ones((4, 4), np.bool_), np.zeros((4, 4, 2), np.float32))
    assert np.array_equal(memory.mean(field(1), ALL, STILL), field(1))


@pytest.mark.parametrize("kind", DETECTORS)
def test_remembering_steadies_the_score_of_ground(scenes: Scenes, kind: type[Detector]) -> None:
    means = []
    for memory_ratio in (0.0, 0.6):
        stage = kind(memory_ratio=memory_ratio)
        stage.reset(0)
        for seed in range(6):
            plane = seen(stage, scenes.scene(0.0, seed=seed), scenes.stamp())
        means.append(plane.score.mean())
    assert means[1] < 0.7 * means[0]  # independent noise would leave one half


@pytest.mark.parametrize("kind", DETECTORS)
def test_a_reset_forgets(scenes: Scenes, kind: type[Detector]) -> None:
    stage = kind()
    stage.reset(0)
    alone = seen(stage, scenes.scene(0.1), scenes.stamp()).score
    seen(stage, scenes.scene(0.35, seed=1), scenes.stamp())
    stage.reset(0)
    assert np.array_equal(seen(stage, scenes.scene(0.1), scenes.stamp()).score, alone)


@pytest.mark.parametrize("kind", [Ica, Homography, Residual])
def test_a_frame_that_was_not_judged_ends_the_memory(scenes: Scenes, kind: type[Detector]) -> None:
    blind = replace(scenes.flow(scenes.floor(3.0, 0.0)), valid=np.zeros((30, 40), np.uint8))
    scores = []
    for befores in ([], [scenes.scene(0.35, seed=1), replace(scenes.scene(0.35), flow=blind)]):
        stage = kind()
        stage.reset(0)
        for before in befores:
            seen(stage, before, scenes.stamp())
        scores.append(seen(stage, scenes.scene(0.1), scenes.stamp()).score)
    assert np.array_equal(scores[0], scores[1])


def test_ground_beside_a_strong_obstacle_is_not_obstacle(scenes: Scenes) -> None:
    scene = scenes.scene(0.0, noise_px=0.0)
    uv_px = scene.planar.planar_uv_px.astype(np.float64)
    uv_px[:, 30:, 1] += 2.0
    uv_px[:, 29, 1] += 0.5  # what windows see of it from beside it
    scene = replace(scene, flow=scenes.flow(uv_px))
    maps = []
    for edge_ratio in (0.0, 0.3):
        stage = Residual(edge_ratio=edge_ratio)
        stage.reset(0)
        maps.append(seen(stage, scene, scenes.stamp()).obstacle)
    assert maps[0][:, 29].all()
    assert not maps[1][:, 29].any()
    assert maps[1][:, 30:].all()


@pytest.mark.parametrize("kind", DETECTORS)
def test_a_gap_of_more_than_three_periods_ends_the_memory(scenes: Scenes, kind: type[Detector]) -> None:
    frames = [scenes.scene(0.35, seed=seed) for seed in range(4)]
    stage, alone = kind(), kind()
    for detector in (stage, alone):
        detector.reset(0)
    for k, frame in enumerate(frames):
        seen(stage, frame, Stamp(100_000 * k))
    if isinstance(alone, Affine):
        alone._rng = copy.deepcopy(stage._rng)  # type: ignore[attr-defined]
    after = seen(stage, scenes.scene(0.1), Stamp(300_000 + 310_000))
    assert np.array_equal(after.score, seen(alone, scenes.scene(0.1), Stamp(0)).score)


@pytest.mark.parametrize("gap_us", [100_000, 290_000])
def test_a_frame_or_two_may_be_lost(scenes: Scenes, gap_us: int) -> None:
    stages = Residual(), Residual(), Residual(memory_ratio=0.0)
    for stage in stages:
        stage.reset(0)
        for k in range(4):
            seen(stage, scenes.scene(0.35, seed=k), Stamp(100_000 * k))
    scores = [
        seen(stage, scenes.scene(0.1), Stamp(300_000 + us)).score
        for stage, us in zip(stages, (100_000, gap_us, 100_000), strict=True)
    ]
    assert np.array_equal(scores[0], scores[1])
    assert not np.array_equal(scores[0], scores[2])


@pytest.mark.parametrize("kind", [Ica, Residual])
def test_a_planar_flow_of_another_interval_is_refused(scenes: Scenes, kind: type[Detector]) -> None:
    scene, stage = scenes.scene(), kind()
    stage.reset(0)
    other = replace(scene, planar=replace(scene.planar, interval_us=200_000))
    with pytest.raises(ValueError, match=r"^the planar flow covers 200000 us, but the flow 100000 us: wire the flow"):
        seen(stage, other, Stamp(0))
    seen(stage, replace(scene, planar=replace(scene.planar, interval_us=100_900)), Stamp(0))
