"""The direct solutions are FastICA."""

from __future__ import annotations

import math
import sys
from subprocess import run
from typing import TYPE_CHECKING

import numpy as np
import pytest
from graphnav_plane.ica import Ica
from graphnav_plane.separation import closed_form, iterated, robust_contrast
from graphnav_plane.separation.iterated import Nonlinearity
from graphnav_plane.separation.whitening import whiten

from graphnav.arrays import Doubles

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scenes

SOURCES = {
    "sparse and flat": lambda rng, n: np.stack([rng.laplace(size=n) ** 3, rng.uniform(-1, 1, n)]),
    "two sparse": lambda rng, n: np.stack([rng.laplace(size=n), rng.laplace(size=n)]),
    "two flat": lambda rng, n: np.stack([rng.uniform(-1, 1, n), rng.uniform(-1, 1, n)]),
}

DIRECT = {"cubic": closed_form.rotation, "gauss": robust_contrast.rotation}
GAUSS = [("gauss", kind) for kind in SOURCES if kind != "two flat"]
"""Its contrast is maximal for sparse samples: it does not look for flat sources."""


def mixed(kind: str, seed: int, n: int = 4000) -> tuple[Doubles, Doubles]:
    """Return mixtures (2, n) and the mixing matrix; every source has unit variance."""
    rng = np.random.default_rng(seed)
    sources = SOURCES[kind](rng, n)
    sources = (sources - sources.mean(axis=1, keepdims=True)) / sources.std(axis=1, keepdims=True)
    mixing = rng.uniform(-1, 1, (2, 2)) + np.diag([2.0, 2.0])
    return mixing @ sources, mixing


def largest_entries(matrix: Doubles) -> Doubles:
    return np.sort(np.abs(matrix).max(axis=1))


@pytest.mark.parametrize(("nonlinearity", "kind"), [*(("cubic", kind) for kind in SOURCES), *GAUSS])
@pytest.mark.parametrize("seed", range(5))
def test_independent_sources_are_recovered(nonlinearity: str, kind: str, seed: int) -> None:
    mixtures, mixing = mixed(kind, seed)
    white = whiten(mixtures, 0.0)
    assert white is not None
    gains = np.abs(DIRECT[nonlinearity](white.samples) @ white.matrix @ mixing)
    # a permutation: one entry near 1 in each row, the other near 0 (sampling leaves some hundredths)
    assert np.sort(gains, axis=1)[:, 1] == pytest.approx([1.0, 1.0], abs=0.02)
    assert np.sort(gains, axis=1)[:, 0] == pytest.approx([0.0, 0.0], abs=0.12)


@pytest.mark.parametrize(("nonlinearity", "kind"), [*(("cubic", kind) for kind in SOURCES), *GAUSS])
@pytest.mark.parametrize("seed", range(5))
def test_scikit_learn_stays_where_the_direct_solution_is(nonlinearity: Nonlinearity, kind: str, seed: int) -> None:
    white = whiten(mixed(kind, seed)[0], 0.0)
    assert white is not None
    closed = DIRECT[nonlinearity](white.samples)
    found, converged = iterated.rotation(white.samples, closed, nonlinearity)
    assert converged
    assert np.abs(np.sum(found * closed, axis=1)) == pytest.approx([1.0, 1.0], abs=1e-6)


@pytest.mark.parametrize("nonlinearity", DIRECT)
@pytest.mark.parametrize("seed", range(5))
def test_scikit_learn_finds_it_from_anywhere_where_one_source_stands_out(nonlinearity: Nonlinearity, seed: int) -> None:
    white = whiten(mixed("sparse and flat", seed)[0], 0.0)
    assert white is not None
    start = np.random.default_rng(seed).standard_normal((2, 2))
    found, _ = iterated.rotation(white.samples, start, nonlinearity)
    agreement = np.abs(found @ DIRECT[nonlinearity](white.samples).T)
    assert agreement.max(axis=1) == pytest.approx([1.0, 1.0], abs=1e-3)


@pytest.mark.parametrize("share", [0.05, 0.1])
@pytest.mark.parametrize("nonlinearity", DIRECT)
def test_both_solvers_see_the_same_obstacle(scenes: Scenes, nonlinearity: Nonlinearity, share: float) -> None:
    scene = scenes.scene(share, turn_rad=0.03)
    planes = []
    for solver in ("direct", "sklearn"):
        stage = Ica(solver=solver, nonlinearity=nonlinearity)
        stage.reset(1)
        for _ in range(2):
            plane = stage.step(scene.flow, scene.planar, scenes.stamp()).plane
        planes.append(plane)
    assert (planes[0].obstacle == planes[1].obstacle).mean() > 0.98


@pytest.mark.parametrize("kind", ["sparse and flat", "two sparse"])
@pytest.mark.parametrize("seed", range(5))
def test_no_other_angle_nearby_has_a_higher_robust_contrast(kind: str, seed: int) -> None:
    white = whiten(mixed(kind, seed)[0], 0.0)
    assert white is not None
    c, s = robust_contrast.rotation(white.samples)[0]
    angles = math.atan2(s, c) + np.append(0.0, np.linspace(-0.05, 0.05, 101))
    y = np.column_stack([np.cos(angles), np.sin(angles)]) @ white.samples
    contrast = np.exp(-y * y / 2).mean(axis=1)
    # the angle of a contrast in float32 is uncertain by 1e-6, which changes a maximum by the square
    assert contrast[0] >= contrast[1:].max() - 1e-9


@pytest.mark.parametrize("kind", SOURCES)
def test_whitening_is_by_the_eigenvectors_of_the_covariance(kind: str) -> None:
    mixtures = mixed(kind, 0)[0]
    white = whiten(mixtures, 0.0)
    assert white is not None
    values, vectors = np.linalg.eigh(np.cov(mixtures, bias=True))
    expected = (vectors / np.sqrt(values)).T
    assert np.abs(white.matrix @ np.linalg.inv(expected)) == pytest.approx(np.eye(2), abs=1e-9)


def test_the_rotation_is_one(scenes: Scenes) -> None:
    for seed in range(5):
        white = whiten(mixed("two sparse", seed)[0], 0.0)
        assert white is not None
        rotation = closed_form.rotation(white.samples)
        assert rotation @ rotation.T == pytest.approx(np.eye(2))


def test_whitening_leaves_unit_variance_and_no_correlation() -> None:
    white = whiten(mixed("two flat", 0)[0] + 5.0, 0.0)
    assert white is not None
    assert np.cov(white.samples, bias=True) == pytest.approx(np.eye(2))


def test_one_mixture_twice_cannot_be_whitened() -> None:
    row = np.linspace(-1.0, 1.0, 50)
    assert whiten(np.stack([row, 2 * row]), 1e-9) is None
    assert whiten(np.stack([row, 0 * row]), 1e-9) is None
    assert whiten(np.zeros((2, 50)), 1e-9) is None


def test_the_score_is_the_parallax_in_pixels(scenes: Scenes) -> None:
    scene = scenes.scene(0.25, noise_px=0.0)
    stage = Ica()
    stage.reset(0)
    plane = stage.step(scene.flow, scene.planar, scenes.stamp()).plane
    parallax_px = np.linalg.norm(scene.flow.uv_px - scene.planar.planar_uv_px, axis=-1)
    assert plane.score == pytest.approx(parallax_px, abs=0.15)


@pytest.mark.parametrize("gain", [0.9, 1.1])
def test_a_planar_flow_of_another_speed_is_no_obstacle(scenes: Scenes, gain: float) -> None:
    scene = scenes.scene(0.25, gain=gain)
    stage = Ica()
    stage.reset(0)
    plane = stage.step(scene.flow, scene.planar, scenes.stamp()).plane
    assert plane.obstacle[~scene.obstacle].mean() < 0.02
    assert plane.obstacle[scene.obstacle].mean() > 0.8


def test_the_component_of_low_variance_is_blind_to_it(scenes: Scenes) -> None:
    scene = scenes.scene(0.25, turn_rad=0.03)
    contrasts = {}
    for component in ("high_variance", "low_variance"):
        stage = Ica(component=component)
        stage.reset(0)
        score = stage.step(scene.flow, scene.planar, scenes.stamp()).plane.score
        contrasts[component] = score[scene.obstacle].mean() / score[~scene.obstacle].mean()
    assert contrasts["high_variance"] > 5
    assert contrasts["low_variance"] < 2


def test_plugging_in_does_not_load_scikit_learn() -> None:
    code = (
        "import sys; from graphnav_plane import graphnav_stages; graphnav_stages(); assert 'sklearn' not in sys.modules"
    )
    assert run([sys.executable, "-c", code], check=False).returncode == 0
