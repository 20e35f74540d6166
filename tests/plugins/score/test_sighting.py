"""Sightings in scenes that are constructed: a camera that looks straight down at columns on a floor."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from graphnav_score.floor_points import floor_points_m
from graphnav_score.sighting import BodyLabels, Sighting
from graphnav_world.rendering.camera import Camera

from graphnav import Latest, Map, Plane, Stamp, State, Truth, Twist
from graphnav.arrays import Doubles

ROWS, COLS = 120, 160
FOCAL_PX, HEIGHT_M = 120.0, 1.0
RADIUS_M = 0.2


def box(x: float, y: float, length: float = 0.2, width: float = 0.2) -> Doubles:
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.asarray(corners * (length / 2, width / 2) + (x, y))


def world(*bodies: Doubles, tilt_rad: float = np.pi / 2) -> Map:
    lower = floor_of_rows(tilt_rad)[-1]
    footprint = np.array([lower[0], lower[-1], lower[-1], lower[0]])
    return Map(
        kind=np.ones(len(bodies), np.uint8),
        height_m=np.full(len(bodies), 0.01),
        vertices_m=np.concatenate([np.zeros((0, 2)), *bodies]),
        body=np.repeat(np.arange(len(bodies)), [len(one) for one in bodies]).astype(np.int32),
        start=np.zeros(3),
        goal_m=np.zeros((0, 2)),
        robot_radius_m=RADIUS_M,
        shortest_m=0.0,
        footprint_m=footprint,
    )


def rays(tilt_rad: float, y: npt.NDArray[np.floating], x: npt.NDArray[np.floating]) -> tuple[Doubles, Doubles]:
    """Return the depth of the floor, and its places in the robot's frame, of pixels off the middle by y and x."""
    down, right = np.meshgrid(y / FOCAL_PX, x / FOCAL_PX, indexing="ij")
    z_m = HEIGHT_M / (np.sin(tilt_rad) + np.cos(tilt_rad) * down)
    return z_m, np.dstack([z_m * (np.cos(tilt_rad) - np.sin(tilt_rad) * down), -z_m * right])


def floor_of_rows(tilt_rad: float) -> Doubles:
    """Return the places of the picture's upper and lower edge on the floor."""
    return rays(tilt_rad, np.array([-ROWS / 2, ROWS / 2]), np.array([-COLS / 2, COLS / 2]))[1]


def truth(world_: Map, x_m: float = 0.0, tilt_rad: float = np.pi / 2) -> Truth:
    """Return what the camera of a robot at ``x_m`` that heads along x sees: flat bodies on the floor."""
    z_m, places = rays(tilt_rad, np.arange(ROWS) - (ROWS - 1) / 2, np.arange(COLS) - (COLS - 1) / 2)
    obstacle = np.zeros((ROWS, COLS), np.uint8)
    for body in range(len(world_.kind)):
        low, high = (f(world_.vertices_m[world_.body == body], axis=0) for f in (np.min, np.max))
        on_map = places + np.array([x_m, 0.0])
        obstacle |= ((on_map > low) & (on_map < high)).all(axis=2).astype(np.uint8)
    return Truth(
        obstacle=obstacle,
        depth_m=z_m.astype(np.float32),
        flow_px=np.zeros((ROWS, COLS, 2), np.float32),
        interval_us=100_000,
    )


def plane(truth_: Truth, share: float) -> Plane:
    """Return a plane on which this share of the true obstacle, from the left, is marked."""
    mask = truth_.obstacle[2::4, 2::4] != 0
    rank = np.cumsum(mask.ravel()).reshape(mask.shape)
    found = (mask & (rank <= round(share * mask.sum()))).astype(np.uint8)
    return Plane(
        obstacle=found, score=found.astype(np.float32), valid=np.ones_like(found), step_px=4, obstacle_ratio=0.0
    )


def state(x_m: float) -> State:
    return State(
        x_m=x_m,
        y_m=0.0,
        yaw_rad=0.0,
        v_mps=0.3,
        omega_radps=0.0,
        clearance_m=1.0,
        contact=False,
        at_goal=False,
        moving=np.zeros((0, 3)),
    )


def drive(
    world_: Map, shares: list[float], commands: list[Twist] | None = None, step_m: float = 0.05, **params: Any
) -> dict[str, float]:
    """Return the metrics of a drive along x in which this share of the visible obstacle is marked in each frame."""
    stage = Sighting(**params)
    stage.reset(0)
    for k, share in enumerate(shares):
        seen = truth(world_, k * step_m)
        command = Latest(commands[k], 0.0) if commands else Latest[Twist]()
        stage.step(plane(seen, share), seen, state(k * step_m), Latest(world_, 0.0), command, Stamp(k * 100_000))
    return dict(stage.summary())


@pytest.mark.parametrize("tilt_rad", [np.pi / 2, 1.3, 1.0, 0.6])
def test_the_camera_is_found_from_the_depth_of_the_floor(tilt_rad: float) -> None:
    world_ = world(tilt_rad=tilt_rad)
    places = rays(tilt_rad, np.arange(ROWS) - (ROWS - 1) / 2, np.arange(COLS) - (COLS - 1) / 2)[1]
    found = floor_points_m(truth(world_, tilt_rad=tilt_rad), world_, 4)
    assert found is not None
    assert found == pytest.approx(places[2::4, 2::4], abs=1e-4)


def test_a_camera_that_shakes_displaces_points_as_documented() -> None:
    still = Camera(height_m=1.0, tilt_deg=75.0, fov_deg=70.0, cols=COLS, rows=ROWS)
    world_ = replace(world(), footprint_m=still.footprint_m())
    shaken = (replace(still, height_m=1.03), replace(still, roll_deg=0.5), replace(still, tilt_deg=75.5))
    for camera, wanted_mm in zip(shaken, (17, 9, 1), strict=True):
        rays_m = camera.rays() @ camera.R_RC.T
        z_m = camera.height_m / -rays_m[..., 2]
        blank = np.zeros((ROWS, COLS), np.uint8)
        seen = Truth(
            obstacle=blank, depth_m=z_m.astype(np.float32), flow_px=np.zeros((ROWS, COLS, 2), np.float32), interval_us=1
        )
        found = floor_points_m(seen, world_, 4)
        assert found is not None
        off_m = found - (rays_m[..., :2] * z_m[..., None])[2::4, 2::4]
        assert 1000 * np.sqrt((off_m**2).sum(axis=2).mean()) == pytest.approx(wanted_mm, abs=0.5)


def test_a_picture_without_ground_says_nothing() -> None:
    world_ = world(box(0.0, 0.0, 9.0, 9.0))
    assert floor_points_m(truth(world_), world_, 4) is None
    assert drive(world_, [1.0, 1.0]) == {"obstacles": 0.0}


def test_labels_tell_bodies_apart_and_walls_are_none() -> None:
    world_ = world(box(1.0, 0.0), box(2.0, 1.0), box(0.0, 3.0, 10.0, 0.1))
    world_.kind[2] = 0
    labels = BodyLabels(world_)
    places = np.array([[1.0, 0.0], [2.0, 1.0], [2.12, 1.0], [1.5, 0.5], [0.0, 3.0], [-50.0, 0.0], [50.0, 90.0]])
    assert labels.at(places.astype(np.float32)).tolist() == [0, 1, 1, -1, -1, -1, -1]


def test_the_first_sighting_is_where_enough_is_marked() -> None:
    metrics = drive(world(box(0.4, 0.0)), [0.0, 0.0, 0.2, 0.4, 1.0])
    assert metrics["obstacles"] == 1
    assert metrics["never_sighted_ratio"] == 0.0
    # The near face is at 0.3 m; the fourth frame is 0.15 m on; the rim is 0.2 m ahead of the robot's middle.
    assert metrics["mean_first_sighting_m"] == metrics["min_first_sighting_m"] == pytest.approx(0.0, abs=1e-6)
    metrics = drive(world(box(0.4, 0.0)), [0.0, 1.0, 0.0])
    assert metrics["mean_first_sighting_m"] == pytest.approx(0.05)
    assert metrics["mean_sighting_delay_m"] == pytest.approx(0.05)


def test_what_is_never_marked_is_never_sighted_and_what_is_far_does_not_count() -> None:
    both = world(box(0.4, 0.0), box(0.4, 0.5))
    assert drive(both, [0.0] * 3)["never_sighted_ratio"] == 1.0
    metrics = drive(both, [1.0] * 3, near_m=0.15)
    assert metrics["obstacles"] == 1
    assert metrics["never_sighted_ratio"] == 0.0


def test_too_few_cells_are_not_visible() -> None:
    assert drive(world(box(0.4, 0.0, 0.04, 0.04)), [1.0] * 3)["obstacles"] == 0
    assert drive(world(box(0.4, 0.0, 0.04, 0.04)), [1.0] * 3, min_cells=1)["obstacles"] == 1


@pytest.mark.parametrize(
    ("y_m", "turn_radps", "v_mps", "reacts"),
    [
        (0.1, -0.2, 0.3, True),
        (0.1, 0.2, 0.3, False),
        (-0.1, 0.2, 0.3, True),
        (-0.1, -0.2, 0.3, False),
        (0.1, 0.0, 0.2, True),
        (0.1, 0.0, 0.28, False),
    ],
)
def test_a_reaction_turns_away_or_slows_down(y_m: float, turn_radps: float, v_mps: float, reacts: bool) -> None:
    straight, other = Twist(v_mps=0.3, omega_radps=0.0), Twist(v_mps=v_mps, omega_radps=turn_radps)
    metrics = drive(world(box(0.45, y_m)), [1.0] * 5, [straight] * 3 + [other] * 2, step_m=0.02)
    assert metrics["reacted_ratio"] == float(reacts)
    assert metrics.get("mean_time_to_react_s") == (pytest.approx(0.3) if reacts else None)


def test_what_is_beside_asks_for_no_reaction_and_without_commands_none_is_measured() -> None:
    straight = [Twist(v_mps=0.3, omega_radps=0.0)] * 3
    assert "reacted_ratio" not in drive(world(box(0.0, 0.5)), [1.0] * 3, straight)
    assert "reacted_ratio" not in drive(world(box(0.4, 0.0)), [1.0] * 3)


def test_without_a_map_or_obstacles_nothing_counts() -> None:
    assert drive(world(), [1.0] * 2) == {"obstacles": 0.0}
    stage = Sighting()
    stage.reset(0)
    seen = truth(world())
    stage.step(plane(seen, 1.0), seen, state(0.0), Latest[Map](), Latest[Twist](), Stamp(0))
    assert stage.summary() == {"obstacles": 0.0}
