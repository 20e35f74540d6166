"""Declared keys of a map."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav import Range, Record, key
from graphnav_world.maps.body_keys import Obstacle, Pillars, Region, Wall
from graphnav_world.maps.corridor_keys import BarnKeys, BarnMovingKeys, CorridorKeys, RingKeys, ZigzagKeys
from graphnav_world.maps.shape_keys import MAX_DEG, MAX_M, Point

MAX_GRAY = 1000.0
"""Beyond white, which is 255, surfaces saturate."""
MAX_RATIO = 100.0


class TextureKeys(Record):
    """How surfaces look: gray noise, or tiles that are all alike.

    What is left out is as in the texture of the same name that always exists (`floor`, `wall`, `obstacle`), else as in
    `obstacle`.
    """

    noun = "a texture"
    example = """
    textures:
      floor: {mean: 125, contrast: 34, grain_m: 0.16}    # these three are the defaults
      wall: {mean: 165, contrast: 26, grain_m: 0.12}
      obstacle: {mean: 90, contrast: 26, grain_m: 0.08}
      brick: {mean: [90, 120]}
      tiles: {mean: 150, contrast: 2, tile_m: 0.3, joint: 70}    # pale tiles, dark joints
    """

    mean: Range[float] | None = key(None, gt=0.0, le=MAX_GRAY, doc="its mean gray level, of 255; more is brighter")
    contrast: Range[float] | None = key(
        None, gt=0.0, le=MAX_GRAY, doc="the standard deviation of its gray levels, of 255"
    )
    grain_m: Range[float] | None = key(None, ge=0.001, le=MAX_M, doc="the size of its largest grains; 0.64 at most")
    tile_m: Range[float] | None = key(
        None,
        ge=0.02,
        le=0.64,
        doc="side of the square tiles, whose faces all show the same noise; no tiles if left out",
    )
    joint_m: Range[float] = key(Range(0.01, 0.01), ge=0.001, le=0.1, doc="width of the joints between tiles")
    joint: Range[float] = key(Range(60.0, 60.0), ge=0.0, le=MAX_GRAY, doc="gray level of the joints, of 255")


class View(Record):
    """Factors on the world's own parameters of the same name."""

    noun = "a view"
    example = "view: {light_ratio: [0.9, 1.1], noise_ratio: 1}"

    light_ratio: Range[float] = key(Range(1.0, 1.0), ge=0.0, le=MAX_RATIO, doc="brightness")
    noise_ratio: Range[float] = key(Range(1.0, 1.0), ge=0.0, le=MAX_RATIO, doc="noise of the image")


class Start(Record):
    """Where the robot begins. It is round, with a radius of 0.2 m if the graph does not set another one."""

    noun = "the start"
    example = "start: {at_m: [0, [-0.5, 0.5]], heading_deg: 90}"

    at_m: Point = key(ge=-MAX_M, le=MAX_M, doc="its centre")
    heading_deg: Range[float] = key(
        Range(0.0, 0.0), ge=-MAX_DEG, le=MAX_DEG, doc="the way that it looks: 0 is along x, 90 along y"
    )


class PassageKeys(Record):
    """Conditions on every drawn world.

    A map with ranges is drawn again until they hold. That a path leads to the goal is always required where there is a
    goal.
    """

    noun = "a passage"
    example = "passage: {margin_m: 0.1, straight_blocked: true}"

    margin_m: Range[float] = key(
        Range(0.0, 0.0), ge=0.0, le=MAX_M, doc="how much the path is wider than the robot, on each side"
    )
    straight_blocked: bool = key(default=False, doc="whether something has to stand in the straight way to the goal")


class MapKeys(Record):
    """Every key may be left out but `start`, and that too where another key brings it.

    `corridor`, `zigzag`, `ring`, `barn` and `barn_moving` do; a map has one of these five at most.
    """

    noun = "a map"

    about: str = key("", doc="the map in one line; not evaluated")
    textures: Mapping[str, TextureKeys] | None = key(None, doc="how surfaces look, by name")
    view: View | None = key(None, doc="light and noise")
    corridor: CorridorKeys | None = key(None, doc="a bent corridor with its start and its goal")
    zigzag: ZigzagKeys | None = key(None, doc="a corridor with sharp corners, with its start and its goal")
    ring: RingKeys | None = key(None, doc="a corridor without an end, with its start")
    barn: BarnKeys | None = key(None, doc="a world of the BARN challenge, with its start and its goal")
    barn_moving: BarnMovingKeys | None = key(
        None, doc="a world of cylinders that move on polynomials, with its start and its goal"
    )
    walls: tuple[Wall, ...] = key((), doc="walls")
    obstacles: tuple[Obstacle, ...] = key((), doc="obstacles that stand or move")
    pillars: Pillars | None = key(None, doc="a field of round obstacles")
    start: Start | None = key(None, doc="where the robot begins")
    goal: Region | None = key(None, doc="where a run ends; without it a run goes on")
    passage: PassageKeys | None = key(None, doc="conditions on every drawn world")
