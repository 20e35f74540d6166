"""The simulated world: a robot with a camera, driven by commands."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from graphnav import (
    Finished,
    Goal,
    Image,
    Latest,
    Map,
    Motion,
    ParamError,
    Source,
    Stamp,
    State,
    Truth,
    Twist,
    param,
)
from graphnav_world import outlines
from graphnav_world.atlas import Atlas, floor_texels
from graphnav_world.camera import Camera
from graphnav_world.exposure import moments
from graphnav_world.placed import Placed
from graphnav_world.render import Frame, Renderer, level_count
from graphnav_world.scene import faces_of
from graphnav_world.vehicle import Limits, Pose, Vehicle
from graphnav_world.world_map import WorldMap, load_map

SMALLEST_FLOOR_M = 10.0
BEYOND_BODIES_M = 2.0


class WorldOutputs(NamedTuple):
    """What the world publishes at a tick; ``motion`` and ``truth`` from the second on, ``map`` at the first."""

    image: Image
    motion: Motion | None
    state: State
    truth: Truth | None
    goal: Goal | None
    map: Map | None


class Pymunk(Source):
    """A round robot with a camera in a world of walls, obstacles and floor, in a pymunk space.

    Each firing drives the period since the last frame with the command sampled then, renders what the camera sees,
    and publishes it with the truth behind it. It ends the run with ``goal`` when the robot's centre is in the map's
    goal region, and with ``contact`` at the first touch.

    Everything has the stamp of the frame: truth, state and the middle of the exposure.
    """

    map: Path = param(doc="the map's YAML file")
    size: tuple[int, int] = param((160, 120), ge=8, le=4096, doc="columns and rows of the image")
    camera_height_m: float = param(1.0, gt=0.0, le=100.0, doc="of the camera above the floor; higher sees farther")
    tilt_deg: float = param(75.0, gt=0.0, le=90.0, doc="of the camera below the horizontal; 90 looks straight down")
    fov_deg: float = param(70.0, ge=5.0, le=150.0, doc="horizontal field of view; more sees wider")
    noise_sigma: float = param(
        2.0, ge=0.0, le=100.0, doc="standard deviation of the image noise, in gray levels, times the map's noise_ratio"
    )
    light_ratio: float = param(1.0, gt=0.0, le=10.0, doc="brightness, times the map's light_ratio")
    light_swing_ratio: float = param(
        0.0, ge=0.0, le=1.0, doc="share by which brightness rises and falls in time, as a sine; 0 is steady light"
    )
    light_period_s: float = param(2.0, gt=0.0, le=1000.0, doc="of the swing of the light; less changes it faster")
    contrast_ratio: float = param(
        1.0, ge=0.0, le=10.0, doc="contrast of all textures, times the map's; 0 leaves surfaces blank"
    )
    exposure_s: float = param(
        0.0, ge=0.0, le=1.0, doc="time that the shutter is open, around the frame's stamp; more blurs motion"
    )
    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="of the robot's body")
    max_speed_mps: float = param(0.5, gt=0.0, le=20.0, doc="greatest speed of the drive, forwards and backwards")
    max_turn_radps: float = param(2.0, gt=0.0, le=20.0, doc="greatest turning rate of the drive, to either side")
    speed_up_s: float = param(0.25, gt=0.0, le=60.0, doc="time from rest to the greatest speed; more is more sluggish")
    turn_up_s: float = param(0.25, gt=0.0, le=60.0, doc="time from rest to the greatest turning rate")
    odometry_scale_ratio: float = param(
        0.02, ge=0.0, lt=1.0, doc="share by which odometry errs throughout a run; the seed draws the signs"
    )
    odometry_noise_ratio: float = param(
        0.01, ge=0.0, lt=1.0, doc="standard deviation of odometry's random error, as a share of each displacement"
    )

    def check(self) -> None:
        """Read the map.

        Raises
        ------
        ParamError
            There is no such map.
        UserError
            The map is wrong; every problem with its place in the map's file.
        """
        self._load(seed=0)

    def reset(self, seed: int) -> None:
        """Draw the map, its textures and the errors of the odometry, and put the robot at the start."""
        loaded = self._load(seed)
        draw = loaded.draw
        paint, self._noise, self._errors = (np.random.default_rng([seed, part]) for part in range(3))
        self._shortest_m = loaded.shortest_m
        self._draw = draw
        self._faces = faces_of(draw.bodies, paint)
        self._camera = Camera(self.camera_height_m, self.tilt_deg, self.fov_deg, *self.size)
        self._renderer = self._make_renderer(paint)
        limits = Limits(self.max_speed_mps, self.max_turn_radps, self.speed_up_s, self.turn_up_s)
        self._vehicle = Vehicle(draw.bodies, draw.start, self.robot_radius_m, limits)
        self._scale = 1 + self.odometry_scale_ratio * self._errors.choice([-1.0, 1.0], size=3)
        self._before: Placed | None = None
        self._begin_us = self._last_us = 0

    def step(self, command: Latest[Twist], utime: Stamp) -> WorldOutputs:
        """Drive until now, look, and tell."""
        first = self._before is None
        if first:
            self._begin_us = self._last_us = utime
        then, pose = self._vehicle.pose, self._vehicle.pose
        if not first:
            twist = command.value or Twist(v_mps=0.0, omega_radps=0.0)
            pose = self._vehicle.advance(twist.v_mps, twist.omega_radps, (utime - self._begin_us) / 1e6)
        interval_us, self._last_us = utime - self._last_us, utime
        time_s = (utime - self._begin_us) / 1e6
        now = Placed.at(self._camera, self._faces, pose.x_m, pose.y_m, pose.yaw_rad, time_s)
        frame = self._look(now, pose, time_s)
        self._before = now
        at_goal = bool(len(self._draw.goal_m)) and outlines.contains(self._draw.goal_m, pose.x_m, pose.y_m)
        outputs = WorldOutputs(
            image=Image(pixels=frame.pixels),
            motion=None if first else self._odometry(then, pose, interval_us),
            state=self._state(pose, now, at_goal=at_goal),
            truth=_truth(frame, interval_us),
            goal=self._beacon(pose),
            map=self._map() if first else None,
        )
        if pose.contact or at_goal:
            raise Finished("contact" if pose.contact else "goal", outputs)
        return outputs

    def _load(self, seed: int) -> WorldMap:
        if not self.map.is_file():
            raise ParamError("map", f"'map' names no file: {self.map}", "give the path of a map's YAML file")
        return load_map(self.map, seed, self.robot_radius_m)

    def _make_renderer(self, rng: np.random.Generator) -> Renderer:
        """Return a renderer whose floor texture covers the map."""
        draw = self._draw
        standing = [body.outline for body in draw.bodies if body.patrol is None]
        points = np.concatenate([[draw.start[:2]], draw.goal_m, *standing])
        low, high = points.min(axis=0) - BEYOND_BODIES_M, points.max(axis=0) + BEYOND_BODIES_M
        lack = np.maximum(SMALLEST_FLOOR_M - (high - low), 0.0)
        textures = [draw.textures[name] for name in ("floor", *self._faces.textures)]
        textures = [replace(one, contrast=one.contrast * self.contrast_ratio) for one in textures]
        atlas = Atlas(textures, floor_texels(high - low + lack), rng, level_count(self._camera))
        return Renderer(self._camera, self._faces, atlas, low - lack / 2)

    def _look(self, now: Placed, pose: Pose, time_s: float) -> Frame:
        swing = 1 + self.light_swing_ratio * math.sin(2 * math.pi * time_s / self.light_period_s)
        meanwhile = [
            Placed.at(self._camera, self._faces, x, y, yaw, time_s + after_s)
            for after_s, (x, y, yaw) in moments(pose, self.exposure_s)
        ]
        return self._renderer.render(
            now,
            self._before,
            meanwhile=meanwhile,
            light=self.light_ratio * self._draw.light_ratio * swing,
            noise_sigma=self.noise_sigma * self._draw.noise_ratio,
            rng=self._noise,
        )

    def _odometry(self, then: Pose, now: Pose, interval_us: int) -> Motion:
        """Return the displacement in the robot's frame of then, with this run's scale errors and fresh noise."""
        c, s = math.cos(then.yaw_rad), math.sin(then.yaw_rad)
        x, y = now.x_m - then.x_m, now.y_m - then.y_m
        turn = math.remainder(now.yaw_rad - then.yaw_rad, 2 * math.pi)
        true = np.array([c * x + s * y, c * y - s * x, turn])
        forward, left, turn = true * self._scale * (1 + self.odometry_noise_ratio * self._errors.standard_normal(3))
        return Motion(forward_m=float(forward), left_m=float(left), turn_rad=float(turn), interval_us=interval_us)

    def _state(self, pose: Pose, now: Placed, *, at_goal: bool) -> State:
        moving = [[at[0], at[1], 0.0] for _, at in now.moving]
        return State(
            x_m=pose.x_m,
            y_m=pose.y_m,
            yaw_rad=pose.yaw_rad,
            v_mps=pose.v_mps,
            omega_radps=pose.omega_radps,
            clearance_m=pose.clearance_m,
            contact=pose.contact,
            at_goal=at_goal,
            moving=np.array(moving, np.float64).reshape(-1, 3),
        )

    def _beacon(self, pose: Pose) -> Goal | None:
        if not len(self._draw.goal_m):
            return None
        x, y = self._draw.goal_m.mean(axis=0) - (pose.x_m, pose.y_m)
        bearing = math.remainder(math.atan2(y, x) - pose.yaw_rad, 2 * math.pi)
        return Goal(bearing_rad=bearing, distance_m=math.hypot(x, y))

    def _map(self) -> Map:
        bodies = self._draw.bodies
        outlines_m = [body.outline for body in bodies]
        return Map(
            kind=np.array([body.kind for body in bodies], np.uint8),
            height_m=np.array([body.height_m for body in bodies], np.float64),
            vertices_m=np.concatenate([np.zeros((0, 2)), *outlines_m]),
            body=np.repeat(np.arange(len(bodies)), [len(one) for one in outlines_m]).astype(np.int32),
            start=np.array(self._draw.start, np.float64),
            goal_m=self._draw.goal_m,
            robot_radius_m=self.robot_radius_m,
            shortest_m=self._shortest_m,
            footprint_m=self._camera.footprint_m(),
        )


def _truth(frame: Frame, interval_us: int) -> Truth | None:
    if frame.flow_px is None:
        return None
    return Truth(obstacle=frame.obstacle, depth_m=frame.depth_m, flow_px=frame.flow_px, interval_us=interval_us)
