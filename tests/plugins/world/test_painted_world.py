"""Runs through one world share its textures, and see what they would see alone."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from graphnav_world.maps.world_map import load_map
from graphnav_world.painted_world import painted_world
from graphnav_world.world import Pymunk

from graphnav import Latest, Stamp

RADIUS_M = 0.2


@pytest.fixture
def map_file(maps: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(maps / "corridor_ccw.yaml", tmp_path))


def frame(map_file: Path, seed: int, contrast_ratio: float = 1.0) -> bytes:
    world = Pymunk(map=map_file, contrast_ratio=contrast_ratio)
    world.reset(seed)
    return world.step(Latest(), Stamp(0)).image.pixels.tobytes()


def test_a_run_in_a_world_that_is_kept_sees_what_a_run_alone_sees(map_file: Path) -> None:
    painted_world.cache_clear()
    alone = frame(map_file, 3)
    hits = painted_world.cache_info().hits
    assert frame(map_file, 3) == alone
    assert painted_world.cache_info().hits == hits + 1
    assert frame(map_file, 4) != alone
    assert frame(map_file, 3, contrast_ratio=0.5) != alone
    assert frame(map_file, 3) == alone


def test_a_map_that_changes_is_another_world(map_file: Path) -> None:
    before, text = load_map(map_file, 0, RADIUS_M), map_file.read_text(encoding="utf-8")
    seen = frame(map_file, 0)
    assert load_map(map_file, 0, RADIUS_M) is before
    assert load_map(map_file, 1, RADIUS_M) is not before
    assert load_map(map_file, 0, 2 * RADIUS_M) is not before
    map_file.write_text(text.replace("[0.9, 1.1]", "[0.5, 0.5]"), encoding="utf-8")
    assert load_map(map_file, 0, RADIUS_M) is not before
    assert frame(map_file, 0) != seen
    map_file.write_text(text, encoding="utf-8")
    assert load_map(map_file, 0, RADIUS_M) is before
    assert frame(map_file, 0) == seen


def test_what_is_kept_is_bounded_and_cannot_be_painted_over(map_file: Path) -> None:
    kept = [painted_world(load_map(map_file, seed, RADIUS_M), seed, 1.0, 6) for seed in range(3)]
    assert painted_world.cache_info().currsize == 1
    with pytest.raises(ValueError, match="read-only"):
        kept[0].atlas.pixels[0, 0] = 0
