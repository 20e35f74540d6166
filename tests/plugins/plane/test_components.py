"""The independent components, as `plane.ica` publishes them, are what the flow and the planar flow are mixed of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from graphnav_plane.ica import Ica

from graphnav import Components
from graphnav.core.stage import tell_readers

if TYPE_CHECKING:
    from tests.plugins.plane.conftest import Scene, Scenes

LITERAL: dict[str, Any] = {"nonlinearity": "cubic", "centred": True, "about": "median", "solver": "sklearn"}
KINDS: list[dict[str, Any]] = [{}, {"component": "low_variance"}, LITERAL]


def separated(scenes: Scenes, scene: Scene, **parameters: Any) -> Components:
    stage = Ica(**parameters)
    stage.reset(0)
    components = stage.step(scene.flow, scene.planar, scenes.stamp()).components
    assert components is not None
    return components


@pytest.mark.parametrize("parameters", KINDS)
def test_their_mixing_is_the_flow_and_the_planar_flow(scenes: Scenes, parameters: dict[str, Any]) -> None:
    scene = scenes.scene(0.25, turn_rad=0.03)
    c = separated(scenes, scene, **parameters)
    for row, field in enumerate((scene.flow.uv_px, scene.planar.planar_uv_px)):
        assert c.mixing[row, 0] * c.alpha + c.mixing[row, 1] * c.beta == pytest.approx(field, abs=1e-5)


@pytest.mark.parametrize("parameters", KINDS)
def test_they_are_uncorrelated_of_unit_variance_and_in_order(scenes: Scenes, parameters: dict[str, Any]) -> None:
    c = separated(scenes, scenes.scene(0.25, turn_rad=0.03), **parameters)
    # Each component is one row of samples: all horizontal parts, then all vertical ones.
    rows = np.array([c.alpha.reshape(-1), c.beta.reshape(-1)], float)
    if parameters.get("centred"):
        rows -= rows.mean(axis=1, keepdims=True)
    assert rows @ rows.T / rows.shape[1] == pytest.approx(np.eye(2), abs=1e-5)
    lengths = [np.hypot(field[..., 0], field[..., 1]) for field in (c.alpha, c.beta)]
    assert c.variances == pytest.approx([length.var() for length in lengths], rel=1e-4)
    assert c.variances[0] < c.variances[1]


@pytest.mark.parametrize(("component", "taken"), [("low_variance", 0), ("high_variance", 1), ("kurtosis", 1)])
def test_the_taken_one_is_the_one_of_the_score(scenes: Scenes, component: Any, taken: int) -> None:
    scene = scenes.scene(0.25, turn_rad=0.03)
    stage = Ica(component=component, memory_ratio=0.0)
    stage.reset(0)
    plane, c = stage.step(scene.flow, scene.planar, scenes.stamp())
    assert c is not None
    assert c.taken == taken
    length = np.linalg.norm((c.alpha, c.beta)[taken], axis=-1)
    # The score is the component in pixels: a multiple of its length.
    assert np.corrcoef(plane.score.reshape(-1), length.reshape(-1))[0, 1] > 1 - 1e-6


def test_they_are_made_only_where_they_are_read(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    stage = Ica()
    tell_readers(stage, ["plane"])
    stage.reset(0)
    assert stage.step(scene.flow, scene.planar, scenes.stamp()).components is None
    tell_readers(stage, ["plane", "components"])
    stage.reset(0)
    assert stage.step(scene.flow, scene.planar, scenes.stamp()).components is not None


def test_cells_that_were_not_separated_are_zero(scenes: Scenes) -> None:
    scene = scenes.scene(0.25)
    scene.flow.valid[:5] = 0
    c = separated(scenes, scene)
    assert not c.alpha[:5].any()
    assert not c.beta[:5].any()
    assert (c.valid == scene.flow.valid).all()


def test_one_mixture_has_no_components(scenes: Scenes) -> None:
    still = scenes.scene(0.0, drive_px=0.0, noise_px=0.0)
    stage = Ica()
    stage.reset(0)
    assert stage.step(still.flow, still.planar, scenes.stamp()).components is None
