"""The neutral appearance: one picture says nothing of what it shows, its motion does."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_world.rendering.hashed_points import LAYERS, parents, points_of, tiles_at
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.world import Pymunk, WorldOutputs
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from graphnav import Latest, Stamp, Twist
from graphnav.arrays import Bytes, Doubles

CELL_PX = 8


def ready(map_file: Path, seed: int, **params: Any) -> Pymunk:
    world = Pymunk(map=map_file, **params)
    world.reset(seed)
    return world


def drive(map_file: Path, ticks: int = 8, **params: Any) -> list[WorldOutputs]:
    world = ready(map_file, 3, **params)
    twist = Twist(v_mps=0.4, omega_radps=0.1)
    return [world.step(Latest(twist, 0.1), Stamp(k * 100_000)) for k in range(ticks)]


def views(world: Pymunk, poses: Doubles) -> list[tuple[Bytes, Bytes]]:
    """Return picture and obstacle mask from poses (x, y, yaw), each without noise."""
    placed = (Placed.at(world._camera, world._faces, *pose) for pose in poses.tolist())
    frames = [world._renderer.render(one, None) for one in placed]
    return [(frame.pixels, frame.obstacle) for frame in frames]


def appearance(picture: Bytes, obstacle: Bytes) -> tuple[Doubles, NDArray[np.bool_]]:
    """Return mean, standard deviation and gradient energies of cells of one kind, (cells, 4), and if it is obstacle."""
    gray = picture.astype(np.float64)
    down, right = (np.square(np.gradient(gray, axis=axis)) for axis in (0, 1))
    cells = {name: _cells(of) for name, of in (("gray", gray), ("down", down), ("right", right), ("is", obstacle))}
    share = cells["is"].mean(axis=1)
    pure = (share == 0) | (share == 1)
    spread = np.log(cells["gray"].std(axis=1) + 1)
    energies = [np.log(cells[name].mean(axis=1) + 1) for name in ("down", "right")]
    return np.stack([cells["gray"].mean(axis=1), spread, *energies], axis=1)[pure], share[pure] == 1


def _cells(image: NDArray[Any]) -> NDArray[Any]:
    rows, cols = (n // CELL_PX for n in image.shape)
    blocks = image[: rows * CELL_PX, : cols * CELL_PX].reshape(rows, CELL_PX, cols, CELL_PX)
    return blocks.swapaxes(1, 2).reshape(rows * cols, -1)


def separation(map_file: Path, *, neutral: bool) -> float:
    """Return the AUROC of a classifier of cells, trained in some worlds and tested in others."""
    features, kinds, worlds = [], [], []
    for seed in range(6):
        world = ready(map_file, seed, neutral=neutral, tilt_deg=60.0)
        rng = np.random.default_rng(seed)
        poses = rng.uniform([0.0, -1.0, -3.1], [5.0, 1.0, 3.1], (10, 3))
        for picture, obstacle in views(world, poses):
            of_cells, is_obstacle = appearance(picture, obstacle)
            features.append(of_cells)
            kinds.append(is_obstacle)
            worlds.append(np.full(len(of_cells), seed))
    x, y, of = (np.concatenate(one) for one in (features, kinds, worlds))
    assert 0.1 < y.mean() < 0.9
    model = make_pipeline(StandardScaler(), LogisticRegression(class_weight="balanced"))
    model.fit(x[of < 3], y[of < 3])
    return float(roc_auc_score(y[of >= 3], model.decision_function(x[of >= 3])))


def test_appearance_separates_nothing(maps: Path) -> None:
    ordinary, neutral = (separation(maps / "pillars.yaml", neutral=one) for one in (False, True))
    assert ordinary > 0.75
    assert neutral == pytest.approx(0.5, abs=0.05)


def test_floor_and_faces_have_the_contrast_of_the_floor(maps: Path) -> None:
    world = ready(maps / "crowded.yaml", 0, neutral=True, tilt_deg=50.0)
    floor = world._draw.textures["floor"]
    poses = np.random.default_rng(0).uniform([0.0, -1.0, -3.1], [4.0, 1.0, 3.1], (60, 3))
    seen = [(picture.astype(float), obstacle == 1) for picture, obstacle in views(world, poses)]
    for kind in (False, True):
        gray = np.concatenate([picture[obstacle == kind] for picture, obstacle in seen])
        assert len(gray) > 50_000
        assert gray.mean() == pytest.approx(floor.mean, rel=0.03)
        assert gray.std() == pytest.approx(floor.contrast, rel=0.08)


@pytest.mark.parametrize("tilt_deg", [75.0, 45.0])
def test_the_noise_moves_with_the_surfaces(tilt_deg: float, maps: Path) -> None:
    outputs = drive(maps / "corridor_ccw.yaml", 24, neutral=True, noise_sigma_gray=0.0, tilt_deg=tilt_deg)
    left, total, pixels = np.sum([_changes(before, now) for before, now in pairwise(outputs[4:])], axis=0)
    assert pixels.min() > 2000
    of_floor, of_obstacle = left / total
    assert of_floor < 0.15, "share of the change between two frames that the true flow does not explain"
    assert of_obstacle < 0.35, "spots stay round where a face is seen at a grazing angle"


def test_flow_is_estimated_about_as_well_as_on_textures(maps: Path) -> None:
    ordinary, neutral = (_endpoint_errors_px(maps / "corridor_ccw.yaml", neutral=one) for one in (False, True))
    assert neutral[0] < ordinary[0] + 0.03
    assert neutral[1] < 1.5 * ordinary[1]


def _endpoint_errors_px(map_file: Path, *, neutral: bool) -> list[float]:
    """Return the mean error of Lucas-Kanade's valid vectors on floor and obstacles."""
    flow_stage, errors = LucasKanade(), list[list[Doubles]]([[], []])
    flow_stage.reset(0)
    for k, out in enumerate(drive(map_file, 40, neutral=neutral)):
        made = flow_stage.step(out.image, Stamp(k * 100_000))
        if made is None or out.truth is None:
            continue
        flow = made.flow
        error = np.linalg.norm(flow.uv_px - out.truth.flow_px, axis=-1)
        for kind, of_kind in enumerate(errors):
            of_kind.append(error[(flow.valid == 1) & (out.truth.obstacle == kind)])
    return [float(np.concatenate(of_kind).mean()) for of_kind in errors]


def _changes(before: WorldOutputs, now: WorldOutputs) -> Doubles:
    """Return sums of gray differences to the warped last frame and to the last frame, and pixels; (3, 2 kinds)."""
    assert now.truth is not None
    assert before.truth is not None
    x, y = np.meshgrid(np.arange(160, dtype=np.float32), np.arange(120, dtype=np.float32))
    from_x, from_y = x - now.truth.flow_px[..., 0], y - now.truth.flow_px[..., 1]
    last = before.image.pixels.astype(np.float32)
    warped = cv2.remap(last, from_x, from_y, cv2.INTER_CUBIC)
    kind_then = cv2.remap(before.truth.obstacle, from_x, from_y, cv2.INTER_NEAREST, borderValue=2)
    same = cv2.erode((kind_then == now.truth.obstacle).astype(np.uint8), np.ones((9, 9), np.uint8)) == 1
    of_kinds = [same & (now.truth.obstacle == kind) for kind in (0, 1)]
    left, total = (np.abs(one - now.image.pixels) for one in (warped, last))
    return np.array([[one[of].sum() for of in of_kinds] for one in (left, total, np.ones_like(last))])


def test_it_repeats_and_leaves_truth_and_drive_alone(maps: Path) -> None:
    plain, one, same = (drive(maps / "crossing.yaml", neutral=neutral) for neutral in (False, True, True))
    for ordinary, first, second in zip(plain[1:], one[1:], same[1:], strict=True):
        assert np.array_equal(first.image.pixels, second.image.pixels)
        assert ordinary.state.x_m == first.state.x_m
        assert ordinary.truth is not None
        assert first.truth is not None
        for field in ("obstacle", "depth_m", "flow_px"):
            assert np.array_equal(getattr(ordinary.truth, field), getattr(first.truth, field))


@pytest.mark.parametrize("density", [0.3, 7.0, 20_000.0])
def test_points_up_to_a_rank_are_a_poisson_process_of_this_density(density: float) -> None:
    side_m = 100 / np.sqrt(density)
    grid = np.linspace(-side_m / 2, side_m / 2, 300)
    place_m = np.stack([axis.reshape(-1) for axis in np.meshgrid(grid, grid)])
    generations = [tiles_at(np.full(place_m.shape[1], 5), place_m, np.full(place_m.shape[1], density))]
    while len(generations) < LAYERS:
        generations.append(parents(generations[-1]))
    points = points_of(np.concatenate(generations), salt=3)
    shown = (points.rank < density) & (np.abs(points.place_m).max(axis=0) < side_m / 2)
    assert (points.plane == 5).all()
    x_m, y_m = points.place_m[:, shown]
    counts, _, _ = np.histogram2d(x_m, y_m, bins=50)
    assert counts.mean() == pytest.approx(4.0, rel=0.04)
    assert counts.var() / counts.mean() == pytest.approx(1.0, abs=0.1), "as of a Poisson process"
    assert points.sign[shown].mean() == pytest.approx(0.0, abs=0.05)
    assert (points.rank[shown] / density < 0.5).mean() == pytest.approx(0.5, abs=0.03)


def test_a_tile_has_its_points_whatever_else_is_in_view() -> None:
    place_m = np.random.default_rng(0).uniform(-3.0, 3.0, (2, 500))
    plane = np.arange(500) % 3
    few, many = (points_of(tiles_at(plane[:n], place_m[:, :n], np.full(n, 50.0)), salt=1) for n in (100, 500))
    rows = {(p, *at) for p, at in zip(many.plane.tolist(), many.place_m.T.tolist(), strict=True)}
    assert {(p, *at) for p, at in zip(few.plane.tolist(), few.place_m.T.tolist(), strict=True)} <= rows
