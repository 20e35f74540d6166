"""The drawn world of the simulated robots, and the messages of a pose in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import cv2
import numpy as np

from graphnav import Image, Map, ParamError, Source, State, Truth, param
from graphnav.arrays import Bytes
from graphnav_world.brightness import AutoExposure, ExposureSteps, Swing
from graphnav_world.camera_motion import CameraMotion, Shake
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import unshaded
from graphnav_world.maps.world_map import WorldMap, load_map
from graphnav_world.painted_world import PaintedWorld, painted_world
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.exposure import driven, moments
from graphnav_world.rendering.film import Film
from graphnav_world.rendering.lens import Lens
from graphnav_world.rendering.lighting import Lighting, Lights
from graphnav_world.rendering.mip import level_count
from graphnav_world.rendering.neutral import NeutralTexture
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Renderer
from graphnav_world.rendering.sensor import AnyFrame, Sensor, Strip
from graphnav_world.rendering.shadows import Caster, Shadows
from graphnav_world.rendering.textures import Texture
from graphnav_world.vehicle import Pose

_OF_PICTURE = ("image",)
_OF_CAMERA = ("image", "truth")
"""The map tells what the camera sees, too: `Map.footprint_m` is for drawings and scores, and no drive reads it."""


Eyes = Callable[[float], Any]
"""Where the camera of a frame is so many seconds after it, as the simulator's renderer takes it."""


class Simulation(Source):
    """A robot with a camera in a world of walls, obstacles and floor.

    Simulators derive from it, and say where the camera of a frame is (`_eyes`) and what it sees from there (`_render`).
    """

    reproducible: ClassVar = ("truth",)

    map: Path = param(doc="the map's YAML file")
    size: tuple[int, int] = param((160, 120), ge=8, le=4096, doc="columns and rows of the image", changes=_OF_CAMERA)
    camera_height_m: float = param(
        1.0, gt=0.0, le=100.0, doc="height of the camera above the floor; higher sees farther", changes=_OF_CAMERA
    )
    tilt_deg: float = param(
        75.0, gt=0.0, le=90.0, doc="tilt of the camera below the horizontal; 90 looks straight down", changes=_OF_CAMERA
    )
    fov_deg: float = param(70.0, ge=5.0, le=150.0, doc="horizontal field of view; more sees wider", changes=_OF_CAMERA)
    camera_roll_deg: float = param(
        0.0,
        ge=-45.0,
        le=45.0,
        doc="roll of the mounting about the robot's forward axis; above 0 the camera's right side is lower",
        changes=_OF_CAMERA,
    )
    distortion: tuple[float, float] = param(
        (0.0, 0.0),
        ge=-1.0,
        le=1.0,
        doc="dimensionless: k1 and k2 of OpenCV's model of a lens, which keeps the focal length that fov_deg gives "
        "without them; k1 below 0 bends straight lines outwards (barrel) and sees farther, above 0 inwards",
        changes=_OF_CAMERA,
    )
    shutter_s: float = param(
        0.0,
        ge=0.0,
        le=1.0,
        doc="readout of a rolling shutter, from the first row to the last; the frame's stamp is the middle row's. "
        "More shears and stretches what moves; 0 reads all rows at once",
        changes=_OF_CAMERA,
    )
    defocus_px: float = param(
        0.0,
        ge=0.0,
        le=20.0,
        doc="radius of the disc into which the lens spreads every point (circle of confusion), before noise; more "
        "blurs more",
        changes=_OF_PICTURE,
    )
    camera_shake_deg: float = param(
        0.0,
        ge=0.0,
        le=5.0,
        doc="standard deviation by which the camera pitches and rolls about its centre, independently, in the robot's "
        "axes; the exposure of a frame has one pose",
        changes=_OF_CAMERA,
    )
    camera_bob_ratio: float = param(
        0.0,
        ge=0.0,
        le=0.1,
        doc="standard deviation of the camera's height, as a share of camera_height_m",
        changes=_OF_CAMERA,
    )
    camera_shake_s: float = param(
        0.2,
        gt=0.0,
        le=60.0,
        doc="correlation time of shake and bob: less is more abrupt, far above a frame's is slow",
        changes=_OF_CAMERA,
    )
    noise_sigma_gray: float = param(
        2.0,
        ge=0.0,
        le=100.0,
        doc="standard deviation of the image noise, multiplied by the map's noise_ratio",
        renamed_from="noise_sigma",
        changes=_OF_PICTURE,
    )
    light_ratio: float = param(1.0, gt=0.0, le=10.0, doc="brightness, times the map's light_ratio", changes=_OF_PICTURE)
    light_swing_ratio: float = param(
        0.0,
        ge=0.0,
        le=1.0,
        doc="share by which brightness rises and falls in time, as a sine; 0 is constant light",
        changes=_OF_PICTURE,
    )
    light_period_s: float = param(
        2.0, ge=0.001, le=1000.0, doc="period of the light's oscillation; less changes it faster", changes=_OF_PICTURE
    )
    exposure_step_ratio: float = param(
        0.0,
        ge=0.0,
        le=4.0,
        doc="jumps of an automatic exposure: at each, brightness is multiplied by a new factor, from 1 / (1 + this) to "
        "1 + this; 0 never jumps",
        changes=_OF_PICTURE,
    )
    exposure_step_s: float = param(
        2.0,
        ge=0.001,
        le=1000.0,
        doc="mean time between jumps of the exposure, each 0.5 to 1.5 times as long; seeded",
        changes=_OF_PICTURE,
    )
    auto_exposure_s: float | None = param(
        None,
        gt=0.0,
        le=60.0,
        doc="time constant by which the camera's gain brings the mean of the picture to auto_exposure_gray; less "
        "follows the light faster, null keeps a gain of 1. Settled at the start; a gain above 1 multiplies the noise",
        changes=_OF_PICTURE,
    )
    auto_exposure_gray: float = param(
        110.0,
        gt=0.0,
        lt=255.0,
        doc="mean of the picture that the automatic exposure aims at; more is brighter, and clips more at white",
        changes=_OF_PICTURE,
    )
    auto_exposure_gain_ratio: tuple[float, float] = param(
        (0.1, 8.0),
        ge=0.01,
        le=100.0,
        doc="smallest and largest gain of the automatic exposure; beyond them the picture stays dark or bright",
        changes=_OF_PICTURE,
    )
    lamp_ratio: float = param(
        0.0,
        ge=0.0,
        le=1.0,
        doc="share of the light that comes from a lamp at the camera, which falls off with distance and with the angle "
        "from the optical axis; the mean of an empty floor stays",
        changes=_OF_PICTURE,
    )
    glare_ratio: float = param(
        0.0,
        ge=0.0,
        le=10.0,
        doc="brightness of that lamp's reflection on the floor at the foot of the mast, as a share of white; it stays "
        "in its place in the picture, and saturates",
        changes=_OF_PICTURE,
    )
    shadow_ratio: float = param(
        0.0,
        ge=0.0,
        le=1.0,
        doc="share of the light that shadows take: soft ones of objects out of view, fixed in the world, and the "
        "robot's own, that of an upright cylinder as high as the camera, which moves with it",
        changes=_OF_PICTURE,
    )
    contrast_ratio: float = param(
        1.0,
        ge=0.0,
        le=10.0,
        doc="contrast of all textures, times the map's; 0 leaves surfaces blank",
        changes=_OF_PICTURE,
    )
    neutral: bool = param(
        False,
        doc="whether floor, walls and obstacles all show one noise, without shading, whose grains are as large and as "
        "many in the picture at any distance and slant: appearance says nothing, only motion does; contrast and "
        "brightness are those of the map's floor",
        changes=_OF_PICTURE,
    )
    exposure_s: float = param(
        0.0,
        ge=0.0,
        le=1.0,
        doc="time that the shutter is open, around the frame's stamp; more blurs motion",
        changes=_OF_PICTURE,
    )
    jpeg_quality: int | None = param(
        None,
        ge=1,
        le=100,
        doc="quality of a compression by JPEG, decoded again; less keeps less detail and shows blocks, null does not "
        "compress",
        changes=_OF_PICTURE,
    )
    robot_radius_m: float = param(0.2, gt=0.0, le=10.0, doc="radius of the robot's body, which is a disc")
    robot_size_m: tuple[float, float] | None = param(
        None,
        gt=0.0,
        le=20.0,
        doc="length and width of a rectangular body instead, around the point about which it turns; null: a disc. "
        "Contacts and clearances are the rectangle's; maps are checked, `steer.oracle` plans and shadows fall for the "
        "circle around it",
    )
    truth: bool | None = param(
        None,
        doc="whether the ground truth of each image is published; null: if a stage or an output reads it",
        changes=("truth",),
    )

    def check(self) -> None:
        """Read the map, and look at the lens.

        Raises
        ------
        ParamError
            The map does not exist, the lens folds its picture, or the gain has no room.
        UserError
            The map is invalid; all problems with their locations in the map's file.
        """
        if (lens := self._lens()) is not None and lens.fault is not None:
            what = f"'distortion' {list(self.distortion)} {lens.fault}"
            raise ParamError(
                "distortion", what, "give a k1 nearer to 0, a k2 of the other sign such as k1**2, or a smaller fov_deg"
            )
        low, high = self.auto_exposure_gain_ratio
        if low > high:
            what = f"'auto_exposure_gain_ratio' is {[low, high]}, which is empty"
            raise ParamError("auto_exposure_gain_ratio", what, "give the smallest gain first")
        self._load(seed=0)

    def reset(self, seed: int) -> None:
        """Draw the map and its textures."""
        loaded = self._load(seed, self.run_seed(seed))
        draw = loaded.draw
        self._noise = np.random.default_rng([seed, 1])
        self._shortest_m = loaded.shortest_m
        self._draw = draw
        goal_m = draw.goal_m if len(draw.goal_m) else np.zeros((1, 2))
        self._goal_center_m: tuple[float, float] = tuple(goal_m.mean(axis=0).tolist())
        self._goal_reach_m = float(np.linalg.norm(goal_m - self._goal_center_m, axis=1).max())
        lens = self._lens()
        self._footprint_m = self._mounted.footprint_m(1.0 if lens is None else lens.corner_ratio)
        self._camera = self._mounted if lens is None else lens.pinhole
        self._sensor = Sensor(self._mounted, lens, self.shutter_s)
        self._all_rows = range(self._camera.rows)
        self._before: Eyes | None = None
        shake = Shake(self.camera_shake_deg, self.camera_bob_ratio, self.camera_shake_s)
        self._camera_motion = CameraMotion(self._camera, shake, np.random.default_rng([seed, 11]))
        levels = level_count(shake.farthest(self._camera))
        painted = painted_world(loaded, seed, self.contrast_ratio, levels)
        self._faces = unshaded(painted.faces) if self.neutral else painted.faces
        self._paint(painted, seed)
        self._swing = Swing(self.light_swing_ratio, self.light_period_s)
        steps_rng = np.random.default_rng([seed, 12])
        self._exposure_steps = ExposureSteps(self.exposure_step_ratio, self.exposure_step_s, steps_rng)
        self._auto_exposure = None
        if self.auto_exposure_s is not None:
            bounds = self.auto_exposure_gain_ratio
            self._auto_exposure = AutoExposure(self.auto_exposure_gray, self.auto_exposure_s, bounds)
        self._has_truth = self.is_read("truth") if self.truth is None else self.truth

    def _paint(self, painted: PaintedWorld, seed: int) -> None:
        """Prepare to render."""
        self._renderer = Renderer(
            self._camera,
            self._faces,
            painted.atlas,
            painted.floor_origin_m,
            lighting=self._lighting(np.random.default_rng([seed, 13])),
            neutral=self._neutral(self._draw.textures["floor"], seed) if self.neutral else None,
        )

    def _load(self, seed: int, run_seed: int | None = None) -> WorldMap:
        if not self.map.is_file():
            raise ParamError("map", f"'map' is not a file: {self.map}", "give the path of a map's YAML file")
        return load_map(self.map, seed, self._radius_m, run_seed)

    @property
    def _mounted(self) -> Camera:
        """The camera of the picture, as it would be without distortion."""
        return Camera(self.camera_height_m, self.tilt_deg, self.fov_deg, *self.size, self.camera_roll_deg)

    def _lens(self) -> Lens | None:
        return Lens(self._mounted, *self.distortion) if any(self.distortion) else None

    @property
    def _radius_m(self) -> float:
        """The radius of the robot's body, or of the circle around a rectangular one."""
        return self.robot_radius_m if self.robot_size_m is None else math.hypot(*self.robot_size_m) / 2

    def _lighting(self, rng: np.random.Generator) -> Lighting | None:
        lights = Lights(self.lamp_ratio, self.glare_ratio, self.shadow_ratio)
        if not lights:
            return None
        robot = Caster(self._radius_m, self.camera_height_m)
        shadows = Shadows(robot, self._camera.focal_px, rng) if lights.shadow else None
        return Lighting(self._camera, self._faces, lights, shadows)

    def _neutral(self, floor: Texture, seed: int) -> NeutralTexture:
        texture = replace(floor, contrast=floor.contrast * self.contrast_ratio)
        return NeutralTexture(self._camera, self._faces, texture, seed)

    def _look(self, pose: Pose, time_s: float, interval_us: int) -> tuple[Image, Truth | None]:
        """Return the frame seen from a pose and its ground truth, None for the first frame and where nothing reads it.

        ``interval_us``: since the last frame.
        """
        eyes = self._eyes(self._camera_motion.at(time_s), pose, time_s)
        before, self._before = self._before if self._has_truth else None, eyes

        def taken(strip: Strip) -> AnyFrame:
            meanwhile = [eyes(strip.after_s + after_s) for after_s in moments(self.exposure_s)]
            then = None if before is None else before(strip.after_s)
            window = None if strip.window == self._all_rows else strip.window
            return self._render(eyes(strip.after_s), then, meanwhile, window)

        frame = self._sensor.read(self._sensor.strips(self._moving_px(pose)), taken)
        return Image(pixels=self._developed(frame, time_s)), _truth(frame, interval_us)

    def _moving_px(self, pose: Pose) -> float:
        """Return about how far the floor below the camera, or what moves on it, moves in the picture as it is read."""
        fastest_mps = max((mover.speed_mps for mover in self._faces.movers), default=0.0)
        per_s = abs(pose.omega_radps) + (abs(pose.v_mps) + fastest_mps) / self.camera_height_m
        return self.shutter_s * self._camera.focal_px * per_s

    def _developed(self, frame: AnyFrame, time_s: float) -> Bytes:
        """Return the picture of a frame."""
        light = self.light_ratio * self._draw.light_ratio * (self._swing.at(time_s) * self._exposure_steps.at(time_s))
        sigma_gray = self.noise_sigma_gray * self._draw.noise_ratio
        gray = frame.gray
        if self._auto_exposure is not None:
            gain = self._auto_exposure.at(time_s, light * cv2.mean(gray)[0] / frame.views)
            light, sigma_gray = light * gain, sigma_gray * max(gain, 1.0)
        film = Film(light, sigma_gray, self._noise, self.defocus_px, self.jpeg_quality)
        pixels = film.exposed(film.blurred(gray), frame.views)
        if self._auto_exposure is not None:
            self._auto_exposure.see(pixels)
        return film.compressed(pixels)

    def _eyes(self, camera: Camera, pose: Pose, time_s: float) -> Eyes:
        """Return where the camera of a frame is at any moment near it."""
        return lambda after_s: Placed.at(camera, self._faces, *driven(pose, after_s), time_s + after_s)

    def _render(self, now: Any, before: Any, meanwhile: list[Any], rows: range | None) -> AnyFrame:
        """Return the frame seen from ``now``, with the flow since ``before``; of some rows, or of all."""
        return self._renderer.render(now, before, meanwhile=meanwhile, rows=rows)

    def _at_goal(self, pose: Pose) -> bool:
        goal_m, (x, y) = self._draw.goal_m, self._goal_center_m
        is_near = math.hypot(pose.x_m - x, pose.y_m - y) <= self._goal_reach_m
        return is_near and bool(len(goal_m)) and outlines.contains(goal_m, pose.x_m, pose.y_m)

    def _state(self, pose: Pose, time_s: float) -> State:
        moving = np.zeros((len(self._faces.movers), 3))
        for position, mover in zip(moving, self._faces.movers, strict=True):
            position[:2] = mover.at(time_s)
        return State(
            x_m=pose.x_m,
            y_m=pose.y_m,
            yaw_rad=pose.yaw_rad,
            v_mps=pose.v_mps,
            omega_radps=pose.omega_radps,
            clearance_m=pose.clearance_m,
            contact=pose.contact,
            at_goal=self._at_goal(pose),
            moving=moving,
        )

    def _map(self) -> Map:
        bodies = self._draw.bodies
        outlines_m = [body.outline for body in bodies]
        kinds, heights_m = [int(body.kind) for body in bodies], [body.height_m for body in bodies]
        if self.robot_size_m is not None:
            outlines_m.append(outlines.box(0.0, 0.0, *self.robot_size_m, 0.0))
            kinds.append(Map.ROBOT)
            heights_m.append(0.0)
        return Map(
            kind=np.array(kinds, np.uint8),
            height_m=np.array(heights_m, np.float64),
            vertices_m=np.concatenate([np.zeros((0, 2)), *outlines_m]),
            body=np.repeat(np.arange(len(kinds)), [len(one) for one in outlines_m]).astype(np.int32),
            start=np.array(self._draw.start, np.float64),
            goal_m=self._draw.goal_m,
            robot_radius_m=self._radius_m,
            shortest_m=self._shortest_m,
            footprint_m=self._footprint_m,
        )


def _truth(frame: AnyFrame, interval_us: int) -> Truth | None:
    flow_px = frame.flow_px
    if flow_px is None:
        return None
    return Truth(obstacle=frame.obstacle, depth_m=frame.depth_m, flow_px=flow_px, interval_us=interval_us)
