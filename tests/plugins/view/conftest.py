"""Logs of runs that never were: a robot on a flat floor between painted walls, seen by a pinhole camera."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from graphnav import About, Flow, Image, Map, Message, Plane, Potential, State, Steering, Twist
from graphnav.arrays import Bools, Bytes, Doubles, Floats
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter, Recording

ROWS, COLS, FOCAL_PX, HEIGHT_M, TILT_RAD = 120, 160, 114.0, 1.0, math.radians(75)
STEP_PX = 4
RADIUS_M, HALF_WIDTH_M = 2.5, 0.65
PERIOD_US = 100_000

GRAPH: dict[str, Any] = {
    "about": "Follow the free floor around a counterclockwise bend; nothing of it was ever driven.",
    "run": {"until_s": 60, "seed": 7},
    "stages": {
        "robot": {"use": "world.pymunk", "with": {}, "in": {"command": "control.twist"}},
        "flow": {"use": "flow.truth", "in": {"image": "robot.image"}},
        "plane": {"use": "plane.truth", "in": {"flow": "flow.flow"}},
        "steer": {"use": "steer.pca", "in": {"plane": "plane.plane"}},
        "control": {"use": "control.nonholonomic", "in": {"steering": "steer.steering"}},
    },
}
CHANNELS: dict[str, type[Message]] = {
    "robot.map": Map,
    "robot.image": Image,
    "robot.state": State,
    "flow.flow": Flow,
    "plane.plane": Plane,
    "steer.steering": Steering,
    "steer.potential": Potential,
    "control.twist": Twist,
}


@dataclass
class Drive:
    """A synthetic run: its length, its end, its omissions."""

    frames: int = 40
    seed: int = 7
    contact: bool = False
    at_goal: bool = False
    moving: bool = False
    lost: tuple[int, ...] = ()
    """Frames in which the pose of the robot is not known: not a number."""
    without: tuple[str, ...] = ()
    graph: dict[str, Any] = field(default_factory=lambda: GRAPH)
    copies: dict[str, str] = field(default_factory=dict)
    """Further channels, and of which one they are a copy."""
    step_px: int = 1
    """Grids are thinned by this, as the tap does."""
    about: bool = True


@pytest.fixture
def record(tmp_path: Path) -> Callable[..., Recording]:
    """Return a function that makes up a drive and reads its log, ``run.lcmlog`` in the test's own folder."""
    return lambda **options: Recording(write_log(tmp_path / "run.lcmlog", Drive(**options)))


def write_log(path: Path, drive: Drive) -> Path:
    """Write the log of ``drive``."""
    types = {name: kind for name, kind in CHANNELS.items() if name not in drive.without}
    types |= {name: CHANNELS[of] for name, of in drive.copies.items()}
    about = About(
        graph_yaml=yaml.safe_dump(drive.graph, sort_keys=False),
        lcm_text="",
        run_id="",
        seed=drive.seed,
        channels=tuple(types),
        types=tuple(f"graphnav_lcm.{kind.lcm_class.__name__}" for kind in types.values()),
    )
    with LogWriter(path) as log:
        if drive.about:
            log.write(About.CHANNEL, 0, encode(about, 0, 0))
        for k in range(drive.frames):
            tick = _tick(k, drive)
            tick |= {name: tick[of] for name, of in drive.copies.items() if of in tick}
            for channel, message in tick.items():
                if channel in types:
                    message = message.thin(drive.step_px) if message.grid else message  # noqa: PLW2901
                    log.write(channel, k * PERIOD_US, encode(message, k * PERIOD_US, k))
    return path


def _pose(k: int) -> Doubles:
    """Return a pose on the corridor's middle line, swaying towards the outer wall."""
    angle = -math.pi / 2 + 0.03 * max(k, 0) / RADIUS_M
    radius = RADIUS_M + 0.3 * math.sin(0.15 * k)
    yaw = angle + math.pi / 2 + 0.25 * math.cos(0.15 * k)
    return np.array([radius * math.cos(angle), RADIUS_M + radius * math.sin(angle), yaw])


def _floor_points(pose: Doubles) -> Doubles:
    """Return where each pixel's ray meets the floor, in W, (rows, cols, 2)."""
    x, y = np.meshgrid((np.arange(COLS) - (COLS - 1) / 2) / FOCAL_PX, (np.arange(ROWS) - (ROWS - 1) / 2) / FOCAL_PX)
    c, s = math.cos(TILT_RAD), math.sin(TILT_RAD)
    ahead, left, down = c - s * y, -x, s + c * y
    scale = HEIGHT_M / down
    return _to_world(np.stack([ahead * scale, left * scale], axis=-1), pose)


def _to_world(points: Doubles, pose: Doubles) -> Doubles:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    turned: Doubles = points @ np.array([[c, s], [-s, c]]) + pose[:2]
    return turned


def _tick(k: int, drive: Drive) -> dict[str, Message]:
    pose = _pose(k)
    last = k == drive.frames - 1
    state = State(
        x_m=math.nan if k in drive.lost else pose[0],
        y_m=pose[1],
        yaw_rad=pose[2],
        v_mps=0.3,
        omega_radps=0.1 if k % 4 else 0.0,
        clearance_m=0.2,
        contact=drive.contact and last,
        at_goal=drive.at_goal and last,
        moving=np.array([_moving_pose(k)] * drive.moving).reshape(-1, 3),
    )
    around: dict[str, Message] = {} if k else {"robot.map": _world(drive)}
    return around | {"robot.state": state} | _seen(k)


@lru_cache(maxsize=128)
def _seen(k: int) -> dict[str, Message]:
    """Return what the camera sees in a frame and what is made of it, which is the same in every drive."""
    floor = _floor_points(_pose(k))
    image = Image(pixels=_picture(floor))
    if k == 0:
        return {"robot.image": image}
    plane = _plane(floor)
    flow = Flow(uv_px=_flow(floor, _pose(k - 1)), valid=_margin(4), interval_us=PERIOD_US)
    return {"robot.image": image, "flow.flow": flow, "plane.plane": plane} | _steered(plane)


def _moving_pose(k: int) -> list[float]:
    angle = 0.9 * math.sin(0.04 * k)
    return [2.5 * math.cos(angle), 2.5 + 2.5 * math.sin(angle), 0.1 * k]


def _obstacle(floor: Doubles) -> Bools:
    away = np.abs(np.hypot(floor[..., 0], floor[..., 1] - RADIUS_M) - RADIUS_M)
    return away > HALF_WIDTH_M


@cache
def _texture() -> Floats:
    noise = np.random.default_rng(3).uniform(0, 255, (512, 512, 3)).astype(np.float32)
    texture: Floats = np.clip((cv2.GaussianBlur(noise, (0, 0), 1.5) - 127) * 3 + 127, 0, 255)
    return texture


def _picture(floor: Doubles) -> Bytes:
    at = np.mod(floor * 100, 511).astype(np.float32)
    seen = cv2.remap(_texture(), at[..., 0], at[..., 1], cv2.INTER_LINEAR)
    seen *= np.where(_obstacle(floor)[..., None], np.array([0.5, 0.6, 0.9]), np.array([0.9, 0.85, 0.75]))
    return np.asarray(np.clip(seen, 0, 255), np.uint8)


def _flow(floor: Doubles, before: Doubles) -> Floats:
    """Return the displacement since ``before`` of what is now at each pixel; walls move 30 % more."""
    c, s = math.cos(before[2]), math.sin(before[2])
    seen = (floor - before[:2]) @ np.array([[c, -s], [s, c]])
    ahead, left = seen[..., 0], seen[..., 1]
    ct, st = math.cos(TILT_RAD), math.sin(TILT_RAD)
    depth = ahead * ct + HEIGHT_M * st
    was = np.stack([-left / depth, (HEIGHT_M * ct - ahead * st) / depth], axis=-1) * FOCAL_PX
    x, y = np.meshgrid(np.arange(COLS) - (COLS - 1) / 2, np.arange(ROWS) - (ROWS - 1) / 2)
    uv = np.stack([x, y], axis=-1) - was
    return np.asarray(uv * np.where(_obstacle(floor), 1.3, 1.0)[..., None], np.float32)


def _margin(cells: int, rows: int = ROWS, cols: int = COLS) -> Bytes:
    valid = np.zeros((rows, cols), np.uint8)
    valid[cells:-cells, cells:-cells] = 1
    return valid


def _plane(floor: Doubles) -> Plane:
    valid = _margin(1, ROWS // STEP_PX, COLS // STEP_PX)
    obstacle = _obstacle(floor[STEP_PX // 2 :: STEP_PX, STEP_PX // 2 :: STEP_PX]).astype(np.uint8) * valid
    ratio = float(obstacle.sum() / valid.sum())
    score = obstacle.astype(np.float32)
    return Plane(obstacle=obstacle, score=score, valid=valid, step_px=STEP_PX, obstacle_ratio=ratio)


def _steered(plane: Plane) -> dict[str, Message]:
    sigma = plane.obstacle.shape[1] / 2
    potential = cv2.GaussianBlur(plane.obstacle * np.float32(255), (0, 0), sigma, borderType=cv2.BORDER_CONSTANT)
    gradient = np.stack(np.gradient(potential)[::-1], axis=-1).astype(np.float32)
    mean = gradient.reshape(-1, 2).mean(axis=0).astype(np.float64)
    length = float(np.hypot(*mean))
    repulsive = np.zeros(2) if length == 0 else 4 * plane.obstacle_ratio * mean * np.array([-1.0, 1.0]) / length
    control = repulsive + np.array([0.0, 1.0])
    theta = math.atan2(-control[0], control[1])
    return {
        "steer.steering": Steering(
            repulsive=repulsive,
            guiding=np.array([0.0, 1.0]),
            control=control,
            theta_rad=theta,
            eigenvalues=np.linalg.eigvalsh(np.cov(gradient.reshape(-1, 2).T, bias=True))[::-1].astype(np.float64),
        ),
        "steer.potential": Potential(potential=potential, gradient=gradient, step_px=plane.step_px),
        "control.twist": Twist(v_mps=0.3 * max(math.cos(theta), 0), omega_radps=1.2 * math.sin(theta)),
    }


def _world(drive: Drive) -> Map:
    angles = np.linspace(-math.pi / 2 - 0.3, math.pi / 2, 60)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    middle = np.array([0.0, RADIUS_M])
    inner, outer = RADIUS_M - HALF_WIDTH_M, RADIUS_M + HALF_WIDTH_M
    walls = [
        np.concatenate([middle + near * ring, middle + far * ring[::-1]])
        for near, far in ((inner - 0.1, inner), (outer, outer + 0.1))
    ]
    box = np.array([[-0.15, -0.1], [0.15, -0.1], [0.15, 0.1], [-0.15, 0.1]])
    bodies = [*walls, box + np.array([2.1, 4.4]), *([box] if drive.moving else [])]
    kind = [0, 0, 1, *([2] if drive.moving else [])]
    angle = math.pi / 2
    goal = middle + np.stack(
        [
            r * np.array([math.cos(a), math.sin(a)])
            for a, r in ((angle - 0.2, inner), (angle - 0.2, outer), (angle, outer), (angle, inner))
        ]
    )
    return Map(
        kind=np.array(kind, np.uint8),
        height_m=np.full(len(kind), 0.35),
        vertices_m=np.concatenate(bodies),
        body=np.repeat(np.arange(len(bodies)), [len(b) for b in bodies]).astype(np.int32),
        start=_pose(0),
        goal_m=goal,
        robot_radius_m=0.2,
        shortest_m=7.4,
        footprint_m=np.array([[-0.21, 0.68], [-0.21, -0.68], [0.92, -0.95], [0.92, 0.95]]),
    )
