"""A texture of tiles repeats, and one without is what it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from graphnav_world.maps.world_map import load_map
from graphnav_world.rendering.textures import TEXEL_M, Texture

from graphnav.arrays import Bytes


def painted(texture: Texture) -> Bytes:
    return texture.pixels(512, 384, np.random.default_rng(0))


@pytest.mark.parametrize("tile_m", [0.02, 0.3, 0.64])
def test_tiles_are_all_alike(tile_m: float) -> None:
    texels, side = painted(Texture(tile_m=tile_m)), round(tile_m / TEXEL_M)
    np.testing.assert_array_equal(texels[side:], texels[:-side])
    np.testing.assert_array_equal(texels[:, side:], texels[:, :-side])


def test_joints_have_their_gray_and_faces_their_mean_and_contrast() -> None:
    texels = painted(Texture(mean=150.0, contrast=5.0, tile_m=0.3, joint_m=0.02, joint=70.0))
    assert (texels[:4] == 70).all()
    assert (texels[:, :4] == 70).all()
    face = texels[4:60, 4:60]
    assert face.mean() == pytest.approx(150, abs=2)
    assert face.std() == pytest.approx(5, abs=1)


def test_a_map_draws_the_size_of_its_tiles(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(
        "start: {at_m: [0, 0]}\ntextures: {floor: {tile_m: [0.2, 0.4], joint: 30}, wall: {mean: 90}}\n",
        encoding="utf-8",
    )
    drawn = [load_map(path, seed, 0.2).draw.textures for seed in range(3)]
    sizes = {one["floor"].tile_m for one in drawn}
    assert len(sizes) == 3
    assert all(size is not None and 0.2 <= size <= 0.4 for size in sizes)
    assert {(one["floor"].joint, one["wall"].tile_m) for one in drawn} == {(30.0, None)}
