"""The simulated world of `world.pymunk`, drawn and driven by MuJoCo."""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
from graphnav_world.geometry.movers import movers_of
from graphnav_world.painted_world import PaintedWorld
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.exposure import driven
from graphnav_world.rendering.sensor import AnyFrame
from graphnav_world.simulation import Eyes
from graphnav_world.slip import Slip
from graphnav_world.vehicle import Base, Limits, Pose
from graphnav_world.world import CameraWorld

from graphnav import ParamError, import_extra, param
from graphnav.arrays import Bytes
from graphnav_mujoco import engine
from graphnav_mujoco.base import Carried, TwoWheels, planar_base, positions
from graphnav_mujoco.eye import Eye, Retina, eye_of
from graphnav_mujoco.model import Chassis, Lights, compile_model


class Mujoco(CameraWorld):
    """The world of `world.pymunk`, drawn and driven by MuJoCo: the second simulator, which says what the first decides.

    Maps, camera, seeds and ports are those of `world.pymunk`; the same seed has the same walls, obstacles and textures.
    OpenGL renders the picture, which has MuJoCo's lights; obstacles, depth and flow of the truth are those of its own
    segmentation and depth buffer. The robot is a differential drive with inertia that friction moves, of which the
    camera's mast pitches and rolls with the base.

    The lamp is a spot light that OpenGL computes at the corners of a grid, its glare the gloss of all surfaces, and
    shadows are those of the sun, cast by all that stands and the robot, with sharp edges.

    A run is the same on the same machine. OSMesa and EGL without a GPU compute alike on most machines, but nothing pins
    that: a log of another machine may differ.
    """

    pictures: Literal["mujoco", "pymunk"] = param(
        "mujoco",
        doc="which simulator draws: with `pymunk` pictures and truth are those that world.pymunk has at the poses of "
        "this drive",
        changes=("image", "truth"),
    )
    physics: Literal["mujoco", "pymunk"] = param(
        "mujoco",
        doc="which simulator drives: with `pymunk` the robot moves as in world.pymunk; with pictures of pymunk all is "
        "as there",
    )
    floor: Literal["map", "brick", "grass", "gravel"] = param(
        "map",
        doc="what covers the floor: the map's texture, or a photograph of scikit-image, whose contrast is multiplied "
        "by contrast_ratio",
        changes=("image",),
    )
    photo_m: float = param(1.5, gt=0.05, le=100.0, doc="side of the photograph on the floor", changes=("image",))

    def check(self) -> None:
        """Read the map, and find MuJoCo, what it draws with, and the photograph.

        Raises
        ------
        ParamError
            The map does not exist, or MuJoCo is to draw neutral surfaces, or pymunk a photograph.
        UserError
            The map is invalid, or what is needed is not installed.
        """
        if self._draws and self.neutral:
            raise ParamError("neutral", "MuJoCo draws no neutral surfaces", "give pictures: pymunk, or neutral: false")
        if not self._draws and self.floor != "map":
            raise ParamError("floor", "only MuJoCo draws photographs", "give pictures: mujoco, or floor: map")
        engine.load()
        if self.floor != "map":
            _photograph(self.floor)
        super().check()

    @property
    def _draws(self) -> bool:
        return self.pictures == "mujoco"

    def reset(self, seed: int) -> None:
        """Draw the map, its textures and all errors, compile the model, and put the robot at the start."""
        self.close()
        super().reset(seed)

    def close(self) -> None:
        """Free what OpenGL holds."""
        retina: Retina | None = getattr(self, "_retina", None)
        if retina is not None:
            retina.close()
        self._retina: Retina | None = None

    def _paint(self, painted: PaintedWorld, seed: int) -> None:
        self._painted = painted
        if not self._draws:
            super()._paint(painted, seed)

    def _new_base(self, limits: Limits, slip: Slip | None) -> Base:
        draw, painted = self._draw, self._painted
        atlas = painted.atlas
        textures = [atlas.texels(k) for k in range(len(atlas.period_m))]
        periods_m = [tuple(one) for one in atlas.period_m.tolist()]
        if self.floor != "map":
            textures[0] = _contrasted(_photograph(self.floor), self.contrast_ratio)
            periods_m[0] = (2 * self.photo_m, 2 * self.photo_m)
        lights = Lights(self.lamp_ratio, self.glare_ratio, self.shadow_ratio)
        chassis = Chassis(self._radius_m, self.robot_size_m)
        model = compile_model(
            draw.bodies, self._faces, textures, periods_m, painted.floor_origin_m, self._camera, lights, chassis
        )
        self._base: TwoWheels | Carried
        if self.physics == "mujoco":
            movers = movers_of(body.course for body in draw.bodies if body.course is not None)
            self._base = TwoWheels(model, draw.start, movers, limits, chassis, slip)
        else:
            self._base = Carried(model, super()._new_base(limits, slip))
        if self._draws:
            self._retina = Retina(
                model, self._base.data, self._camera, lights.headroom, has_shadows=bool(self.shadow_ratio)
            )
        return self._base

    def _eyes(self, camera: Camera, pose: Pose, time_s: float) -> Eyes:
        if self._retina is None:
            return super()._eyes(camera, pose, time_s)
        origin, R_WB = self._base.base
        _, upright = planar_base(pose.x_m, pose.y_m, pose.yaw_rad)
        lean, movers = upright.T @ R_WB, self._base.movers

        def eye(after_s: float) -> Eye:
            at, R_W = origin, R_WB
            if after_s:
                at, R_W = planar_base(*driven(pose, after_s))
                at[2] = origin[2]
                R_W = R_W @ lean
            return eye_of(camera, at, R_W, positions(movers, time_s + after_s))

        return eye

    def _render(self, now: Any, before: Any, meanwhile: list[Any], rows: range | None) -> AnyFrame:
        if self._retina is None:
            return super()._render(now, before, meanwhile, rows)
        return self._retina.frame(now, before, meanwhile, rows)


def _photograph(name: str) -> Bytes:
    """Return a photograph of a floor beside its mirror images, gray, uint8: it tiles without a seam."""
    data = import_extra("skimage.data", "photos", f"floor: {name}", "scikit-image")
    picture = np.asarray(getattr(data, name)())
    gray: Bytes = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    row = np.hstack([gray, gray[:, ::-1]])
    return np.vstack([row, row[::-1]])


def _contrasted(gray: Bytes, ratio: float) -> Bytes:
    mean = float(gray.mean())
    contrasted: Bytes = np.clip(np.rint(mean + ratio * (gray - mean)), 0, 255).astype(np.uint8)
    return contrasted
