"""The map against an independent projection of pillars: where they are on it, what it remembers and what it forgets."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from graphnav_mapping.local import Local, MaskMount
from graphnav_mapping.rolling_grid import RollingGrid

from graphnav import FlowDeviation, Latest, LocalMap, Motion, ParamError, Plane, RecoveryState, Stamp
from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.graph import load_graph

from .conftest import Camera, Pillar, seen_plane

CELL_M, FOOT_M, PERIOD_US = 0.05, 0.1, 100_000
NEAR_M = 1.5 * CELL_M
"""Half a cell each for the map's and the picture's cells and for the shift of the grid."""
PILLAR = Pillar(0.9, 0.15)

See = Callable[[Camera], Plane]


class Drive:
    """A stage that is fed with what a camera sees; the evidence of one moving frame is enough."""

    def __init__(self, **parameters: Any) -> None:
        given: dict[str, Any] = {
            "tilt_deg": 60.0,
            "size_m": 4.0,
            "cell_m": CELL_M,
            "max_distance_m": 1.5,
            "hit": 1.0,
            "miss": 0.5,
            "max_evidence": 2.0,
            "max_free_evidence": 1.0,
            "ahead_s": 0.0,
            "full_motion_m": 0.02,
            "blind_height_m": 0.0,
            "foot_m": FOOT_M,
            "presumed_m": 0.0,
            "min_unknown_m2": 0.0,
            "unjudged": "unknown",
            "robot_radius_m": 0.1,
        }
        self.stage = Local(**(given | parameters))
        self.stage.reset(seed=0)
        self.camera = Camera(ahead_m=parameters.get("camera_forward_m", 0.0))
        self.utime = 0

    def step(self, see: See, chord_m: float = 0.03, turn_rad: float = 0.0, period_us: int = PERIOD_US) -> LocalMap:
        """Drive an arc, and return the map with what the camera sees from there."""
        self.camera = self.camera.driven(chord_m, turn_rad)
        self.utime += period_us
        forward_m, left_m = chord_m * math.cos(turn_rad / 2), chord_m * math.sin(turn_rad / 2)
        motion = Motion(forward_m, left_m, turn_rad, period_us)
        return self.stage.step(see(self.camera), motion, Stamp(self.utime))

    def steps(self, see: See, motions: Iterable[tuple[float, float]]) -> LocalMap:
        """Drive arcs, and return the last map."""
        return [self.step(see, *motion) for motion in motions][-1]


def pillars(*there: Pillar) -> See:
    return lambda camera: seen_plane(camera, *there)


def obstacles_m(map: LocalMap) -> np.ndarray:  # noqa: A002  # the port's name
    """Return the middles of the obstacle's cells (n, 2)."""
    rows, cols = np.nonzero(map.state == LocalMap.OBSTACLE)
    return np.column_stack([map.origin_x_m + cols * map.cell_m, map.origin_y_m + rows * map.cell_m])


def is_there(map: LocalMap, pillar: Pillar, seen_from: Camera) -> None:  # noqa: A002
    """Check that the map shows a pillar where it is, and otherwise only in its shadow."""
    points, middle = obstacles_m(map), np.array([pillar.x_m, pillar.y_m])
    assert len(points)
    away = middle - seen_from.middle[:2]
    distance_m = float(np.linalg.norm(away))
    near_side = middle - pillar.radius_m * away / distance_m
    assert np.linalg.norm(points - near_side, axis=1).min() < NEAR_M
    # The floor behind the foot is hidden: slivers of the shadow's rims, a pixel wide, may be marked there.
    is_at_foot = np.linalg.norm(points - middle, axis=1) < pillar.radius_m + FOOT_M + NEAR_M
    assert is_at_foot.mean() > 0.7
    seen = points - seen_from.middle[:2]
    aside_m = np.abs(seen @ [-away[1], away[0]]) / distance_m
    assert (aside_m < (pillar.radius_m + NEAR_M) * np.maximum(np.linalg.norm(seen, axis=1) / distance_m, 1.0)).all()
    # Nothing is nearer to the camera than the pillar.
    assert np.linalg.norm(points - seen_from.middle[:2], axis=1).min() > np.linalg.norm(away) - pillar.radius_m - NEAR_M


def state_at(map: LocalMap, x_m: float, y_m: float) -> int:  # noqa: A002
    (row,), (col,) = map.cells_of(np.array([x_m]), np.array([y_m]))
    return int(map.state[row, col])


@pytest.mark.parametrize("ahead_m", [0.0, 0.2])
@pytest.mark.parametrize("pillar", [PILLAR, Pillar(1.1, -0.3), Pillar(0.7, 0.0, radius_m=0.15)])
def test_an_obstacle_is_where_it_is(pillar: Pillar, ahead_m: float) -> None:
    drive = Drive(camera_forward_m=ahead_m)
    first = drive.step(pillars(pillar), 0.02)
    is_there(first, pillar, drive.camera)
    later = drive.steps(pillars(pillar), [(0.02, 0.05), (0.02, -0.05), (0.02, -0.05)])
    is_there(later, pillar, drive.camera)


def test_the_pose_is_that_of_the_robot() -> None:
    drive = Drive()
    map_ = drive.steps(pillars(), [(0.03, 0.1)] * 80)
    # Displacements and turns are added exactly; 80 roundings of a double stay below a nanometre.
    assert (map_.x_m, map_.y_m) == pytest.approx((drive.camera.x_m, drive.camera.y_m), abs=1e-9)
    assert map_.yaw_rad == pytest.approx(math.remainder(drive.camera.yaw_rad, 2 * math.pi), abs=1e-9)


def test_it_remembers_what_has_left_the_view_while_the_grid_moves_along() -> None:
    pillar = Pillar(0.8, 0.35)
    drive = Drive()
    start = drive.step(pillars(pillar))
    map_ = drive.steps(pillars(pillar), [(0.03, 0.0)] * 45)
    assert not seen_plane(drive.camera, pillar).obstacle.any()
    assert map_.origin_x_m > start.origin_x_m + 0.5
    points = obstacles_m(map_)
    assert np.linalg.norm(points - [pillar.x_m, pillar.y_m], axis=1).max() < pillar.radius_m + FOOT_M + NEAR_M
    middle_m = map_.origin_x_m + (map_.state.shape[1] - 1) / 2 * map_.cell_m
    assert abs(map_.x_m - middle_m) <= (map_.state.shape[1] // 8 + 1) * map_.cell_m


def test_places_stay_when_the_grid_is_shifted() -> None:
    pillar = Pillar(0.8, 0.35)
    drive = Drive()
    drive.steps(pillars(pillar), [(0.03, 0.0)] * 25)
    before = drive.step(pillars(pillar))
    after = before
    while after.origin_x_m == before.origin_x_m:
        before, after = after, drive.step(lambda _: unjudged())
    shift = round((after.origin_x_m - before.origin_x_m) / CELL_M)
    assert (after.origin_x_m - before.origin_x_m) / CELL_M == pytest.approx(shift, abs=1e-6)
    # The floor below the robot, which becomes free, is the only news.
    changed = before.state[:, shift:] != after.state[:, :-shift]
    rows, cols = np.nonzero(changed)
    apart_m = np.hypot(after.origin_x_m + cols * CELL_M - after.x_m, after.origin_y_m + rows * CELL_M - after.y_m)
    assert apart_m.max(initial=0.0) < 0.1 + NEAR_M
    assert (after.state[:, -shift:] == LocalMap.UNKNOWN).all()


def test_what_was_never_judged_is_unknown() -> None:
    drive = Drive()
    map_ = drive.steps(pillars(PILLAR), [(0.02, 0.0)] * 3)
    assert state_at(map_, 0.5, 0.0) == LocalMap.FREE
    assert state_at(map_, 0.0, 0.0) == LocalMap.FREE
    for x_m, y_m in ((-0.5, 0.0), (1.7, 0.0), (0.3, 0.9), (0.3, -0.9)):
        assert state_at(map_, x_m, y_m) == LocalMap.UNKNOWN
    # The floor that the pillar hides.
    assert state_at(map_, PILLAR.x_m + PILLAR.radius_m + FOOT_M + 0.15, PILLAR.y_m * 1.35) == LocalMap.UNKNOWN


def test_cells_that_are_not_valid_tell_nothing() -> None:
    drive = Drive()
    map_ = drive.steps(lambda _: unjudged(), [(0.03, 0.0)] * 5)
    assert not (map_.state == LocalMap.OBSTACLE).any()
    assert state_at(map_, 0.6, 0.0) == LocalMap.UNKNOWN


def test_frames_count_only_while_the_robot_drives() -> None:
    standing = Drive()
    map_ = standing.steps(pillars(PILLAR), [(0.0, 0.0)] * 20)
    assert not (map_.state == LocalMap.OBSTACLE).any()
    assert state_at(map_, 0.5, 0.0) == LocalMap.UNKNOWN
    slow = Drive(full_motion_m=0.04)
    assert not len(obstacles_m(slow.step(pillars(PILLAR), 0.02)))
    # Where it lies does not depend on how fast the robot is.
    is_there(slow.steps(pillars(PILLAR), [(0.02, 0.0)] * 3), PILLAR, slow.camera)


def test_a_robot_that_has_not_set_out_presumes_that_ground_is_free() -> None:
    drive = Drive(presumed_m=0.1)
    map_ = drive.step(pillars(PILLAR), 0.0)
    assert state_at(map_, 0.5, 0.0) == LocalMap.FREE
    assert state_at(map_, PILLAR.x_m - PILLAR.radius_m + CELL_M, PILLAR.y_m) != LocalMap.FREE
    assert state_at(map_, -0.5, 0.0) == LocalMap.UNKNOWN


def test_an_obstacle_that_is_gone_disappears() -> None:
    drive = Drive()
    assert len(obstacles_m(drive.steps(pillars(PILLAR), [(0.01, 0.0)] * 4)))
    # From the maximum evidence, 2, to that of free floor in steps of at most 0.5, at half of the full motion.
    map_ = drive.steps(pillars(), [(0.01, 0.0)] * 12)
    assert not len(obstacles_m(map_))
    assert state_at(map_, PILLAR.x_m, PILLAR.y_m) == LocalMap.FREE


@pytest.mark.parametrize("gap_us", [10 * PERIOD_US, -PERIOD_US])
def test_it_restarts_after_a_gap(gap_us: int) -> None:
    drive = Drive()
    drive.steps(pillars(PILLAR), [(0.03, 0.1)] * 5)
    map_ = drive.step(lambda _: unjudged(), 0.0, 0.0, gap_us)
    assert (map_.x_m, map_.y_m, map_.yaw_rad) == (0.0, 0.0, 0.0)
    assert not len(obstacles_m(map_))


def test_an_obstacle_that_moves_blocks_the_floor_ahead_of_it() -> None:
    speed_mps, ahead_s = 0.25, 2.0
    maps = []
    for time_s in (0.0, ahead_s):
        drive = Drive(ahead_s=time_s, min_mover_mps=0.1, max_mover_mps=0.5)
        for frame in range(16):
            mover = Pillar(1.0, -0.5 + speed_mps * frame * PERIOD_US * 1e-6)
            map_ = drive.step(pillars(mover), 0.01)
        maps.append(map_)
    alone, ahead = maps
    # Half of the way that it has before it; the speed is known to a cell in 0.8 s.
    y_m = mover.y_m + mover.radius_m + speed_mps * ahead_s / 2
    assert state_at(alone, mover.x_m - 0.05, y_m) < LocalMap.OBSTACLE
    assert state_at(ahead, mover.x_m - 0.05, y_m) == LocalMap.MOVING
    assert not (alone.state == LocalMap.MOVING).any()
    beyond_m = mover.y_m + mover.radius_m + (speed_mps + CELL_M / 0.8) * ahead_s + 2 * NEAR_M
    rows, _ = np.nonzero(ahead.state >= LocalMap.OBSTACLE)
    assert (ahead.origin_y_m + rows * CELL_M).max() < beyond_m
    assert (ahead.obstacle_m[ahead.state == LocalMap.MOVING] == 0.0).all()


def test_a_pillar_that_stands_does_not_move() -> None:
    drive = Drive(ahead_s=2.0)
    maps = [drive.step(pillars(PILLAR), 0.02, 0.02) for _ in range(20)]
    assert not any((map_.state == LocalMap.MOVING).any() for map_ in maps)


def test_what_a_single_frame_shows_elsewhere_does_not_move() -> None:
    def moving(n_elsewhere: int) -> list[bool]:
        drive = Drive(ahead_s=2.0, min_mover_mps=0.1, max_mover_mps=0.5)
        stands, elsewhere = Pillar(1.0, -0.2), Pillar(1.0, 0.0)
        seen = [stands] * 15 + [elsewhere] * n_elsewhere
        return [bool((drive.step(pillars(one), 0.01).state == LocalMap.MOVING).any()) for one in seen]

    assert not any(moving(1))
    assert moving(2) == [False] * 16 + [True]


def test_small_unknown_floor_counts_as_free() -> None:
    def see(camera: Camera) -> Plane:
        seen = seen_plane(camera)
        seen.valid[70:76, 70:76] = 0
        return seen

    maps = [Drive(min_unknown_m2=area_m2, presumed_m=0.1).steps(see, [(0.01, 0.0)] * 1) for area_m2 in (0.0, 0.02)]
    kept, filled = ((map_.state == LocalMap.UNKNOWN) for map_ in maps)
    assert 0 < (kept & ~filled).sum() * CELL_M**2 < 0.02
    assert (maps[1].state[kept & ~filled] == LocalMap.FREE).all()
    assert (filled & ~kept).sum() == 0


@pytest.mark.parametrize(("unjudged_is", "expected"), [("obstacle", LocalMap.OBSTACLE), ("unknown", LocalMap.UNKNOWN)])
def test_what_cannot_be_judged_inside_the_rim_is_what_it_is_told(unjudged_is: str, expected: int) -> None:
    drive = Drive(unjudged=unjudged_is)
    map_ = drive.steps(lambda _: unjudged(), [(0.03, 0.0)] * 5)
    assert (map_.state == expected).any()
    assert (map_.state == LocalMap.OBSTACLE).any() == (expected == LocalMap.OBSTACLE)


def test_distances_are_those_to_the_rims_of_cells() -> None:
    map_ = Drive().step(pillars(PILLAR))
    points = obstacles_m(map_)
    for row, col in ((40, 40), (45, 60), (10, 70)):
        place = np.array([map_.origin_x_m + col * CELL_M, map_.origin_y_m + row * CELL_M])
        apart_m = np.linalg.norm(points - place, axis=1).min() - CELL_M / 2
        assert map_.obstacle_m[row, col] == pytest.approx(max(apart_m, 0.0), abs=1e-5)
    assert (map_.obstacle_m[map_.state == LocalMap.OBSTACLE] == 0.0).all()
    assert (map_.unknown_m[map_.state == LocalMap.UNKNOWN] == 0.0).all()
    assert (map_.unknown_m[map_.state != LocalMap.UNKNOWN] > 0.0).all()


def test_the_same_frames_give_the_same_map() -> None:
    one, other = (Drive().steps(pillars(PILLAR), [(0.03, 0.05)] * 10) for _ in range(2))
    assert np.array_equal(one.state, other.state)
    assert np.array_equal(one.obstacle_m, other.obstacle_m)


def test_the_map_of_the_shipped_graph_is_below_a_packet() -> None:
    local = load_graph("navigate", Catalog()).make_stages()["local"]
    local.reset(seed=0)
    map_ = local.step(plane=unjudged(), motion=Motion(0.02, 0.0, 0.0, PERIOD_US), stamp=Stamp(PERIOD_US))  # type: ignore[attr-defined]
    assert len(encode(map_, PERIOD_US, 1)) <= 60_000


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (0.8, -0.3, 2.5), (-1.0, 0.9, -0.7)])
def test_all_that_the_picture_shows_is_in_the_box_of_its_floor(pose: tuple[float, float, float]) -> None:
    rows, cols, mount = 30, 40, MaskMount(1.0, 55.0, 70.0, 0.2)
    near = mount.floor_distance_m(rows, cols) <= 2.0
    grid = RollingGrid(9.0, CELL_M)
    grid.x_m, grid.y_m, grid.yaw_rad = pose
    shown_by = grid.shown_by((rows, cols), mount.floor_to_pixels(rows, cols), grid.box)
    is_near = np.append(False, near)[shown_by]  # 0 stands for no cell
    box = grid.box_of(mount.hull_m(near))
    assert np.count_nonzero(is_near) > 1000
    assert np.count_nonzero(is_near[box.cells]) == np.count_nonzero(is_near)
    assert box.shape[0] * box.shape[1] < is_near.size / 3
    inner = grid.shown_by((rows, cols), mount.floor_to_pixels(rows, cols), box)
    assert np.array_equal(inner, shown_by[box.cells])


def unjudged() -> Plane:
    """Return a plane of which no cell is judged."""
    nothing = np.zeros((120, 160), np.uint8)
    return Plane(nothing, nothing.astype(np.float32), nothing, 1, 0.0)


@pytest.mark.parametrize("jump_m", [2.5, 1e20, -1e300])
def test_it_restarts_where_odometry_jumps(jump_m: float) -> None:
    drive = Drive()
    drive.steps(pillars(PILLAR), [(0.03, 0.0)] * 3)
    drive.step(pillars(), jump_m)
    map_ = drive.stage.step(seen_plane(Camera()), Motion(0.03, 0.0, 0.0, PERIOD_US), Stamp(drive.utime + PERIOD_US))
    assert (map_.x_m, map_.y_m, map_.yaw_rad) == pytest.approx((0.03, 0.0, 0.0))
    assert not len(obstacles_m(map_))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"size_m": 4.0, "cell_m": 1.0}, "'size_m' 4 and 'cell_m' 1 give a map of 4 cells to a side"),
        ({"size_m": 100.0, "cell_m": 0.001}, "'size_m' 100 and 'cell_m' 0.001 give a map of 100000 cells to a side"),
        ({"ahead_s": 3.0, "max_mover_mps": 5.0, "cell_m": 0.02}, "'max_mover_mps' 5 is 200 cells in 0.8 s"),
    ],
)
def test_a_grid_that_cannot_be_searched_is_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ParamError, match=said):
        Local(**wrong).check()


def test_a_judgement_by_flow_that_is_likely_to_be_off_counts_for_less() -> None:
    def evidence(deviation_px: float | None) -> float:
        drive = Drive(max_evidence=100.0, sure_px=0.1)
        plane, motion = pillars(PILLAR)(drive.camera), Motion(0.03, 0.0, 0.0, PERIOD_US)
        there = np.full(plane.valid.shape, deviation_px or 0.0, np.float32)
        known = None if deviation_px is None else FlowDeviation(deviation_px=there, step_px=plane.step_px)
        drive.stage.step(plane, motion, Stamp(PERIOD_US), known)
        return float(drive.stage._grid.evidence.max())

    assert evidence(0.05) == evidence(None)
    assert evidence(0.2) == pytest.approx(evidence(None) / 4)


def recovering(drive: Drive, recoveries: int, doubt: float) -> LocalMap:
    """Return the map after a recovery has begun, of a robot that stands."""
    recovery = RecoveryState(doing="look_again", recoveries=recoveries, turned_rad=13.0, doubt=doubt)
    drive.utime += PERIOD_US
    standing = Motion(0.0, 0.0, 0.0, PERIOD_US)
    return drive.stage.step(unjudged(), standing, Stamp(drive.utime), None, Latest(recovery, 0.1))


def test_obstacles_that_few_frames_have_shown_are_forgotten_when_a_recovery_begins() -> None:
    drive = Drive(min_unknown_m2=1.0)
    drive.steps(pillars(PILLAR), [(0.02, 0.0)] * 6)
    at_foot = tuple(obstacles_m(drive.step(pillars(PILLAR), 0.0))[0])
    assert state_at(recovering(drive, 0, 100.0), *at_foot) == LocalMap.OBSTACLE, "none has begun"
    assert state_at(recovering(drive, 1, 1.0), *at_foot) == LocalMap.OBSTACLE, "as many frames have shown it"
    forgetting = recovering(drive, 2, 100.0)
    assert not len(obstacles_m(forgetting))
    assert state_at(forgetting, *at_foot) == LocalMap.UNKNOWN, "however small, it does not count as free"
    # What is really there is seen again, and once for all: the same recovery does not forget it again.
    is_there(drive.steps(pillars(PILLAR), [(0.02, 0.0)] * 2), PILLAR, drive.camera)
    assert len(obstacles_m(recovering(drive, 2, 100.0)))


def test_frames_that_show_floor_count_against_what_was_shown() -> None:
    drive = Drive(max_evidence=100.0, miss=0.01)
    drive.steps(pillars(PILLAR), [(0.02, 0.0)] * 6)
    drive.steps(pillars(), [(0.02, 0.0)] * 4)
    assert len(obstacles_m(recovering(drive, 1, 1.0)))
    assert not len(obstacles_m(recovering(drive, 2, 4.0)))
