"""The camera of MuJoCo: pictures, and the truth of its own buffers."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from graphnav_world.geometry.scene import SUN_W
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.render import MIN_DEPTH_RATIO

from graphnav.arrays import Bools, Bytes, Doubles, Floats, Ints
from graphnav_mujoco import engine
from graphnav_mujoco.model import BODY, FAR_M, HULL_GROUP, NEAR_M, SUN_M

_GL_FROM_C = np.array([1.0, -1.0, -1.0])
"""OpenGL's cameras have y up and look along -z."""
GREEN = 1
_SEGMENT_BASES = np.array([1, 1 << 8, 1 << 16])


@dataclass(frozen=True)
class Eye:
    """Where the camera is: its mounting at this time, its centre and its axes in W, and where moving bodies are.

    ``moving``: x and y of each, (bodies, 2).
    """

    camera: Camera
    center_W: Doubles  # noqa: N815  # the frame's letter
    R_WC: Doubles
    moving: Doubles


@dataclass(frozen=True)
class Buffers:
    """Buffers of MuJoCo for a frame: the geom that each pixel shows, -1 for none, and its depth along the axis (m)."""

    geom: Ints
    depth_m: Floats


@dataclass(frozen=True)
class MujocoFrame:
    """The gray values of some rows and their truth.

    ``gray``: float32 (rows, cols), the sum of all views. ``truth``: None where nothing reads it. ``before``: None for a
    first frame.
    """

    gray: Floats
    views: int
    first_row: int
    truth: Buffers | None
    is_body: Bools
    mover_of_geom: Ints
    now: Eye
    before: Eye | None

    @cached_property
    def _buffers(self) -> Buffers:
        assert self.truth is not None
        return self.truth

    @property
    def surface(self) -> Ints:
        """The geom that each pixel shows, -1 for none."""
        return self._buffers.geom

    @property
    def obstacle(self) -> Bytes:
        """Where a body is seen, by MuJoCo's segmentation."""
        obstacle: Bytes = self.is_body.take(self._buffers.geom).astype(np.uint8)
        return obstacle

    @property
    def depth_m(self) -> Floats:
        """Depth along the optical axis by MuJoCo's depth buffer, infinite above the horizon."""
        return self._buffers.depth_m

    @property
    def flow_px(self) -> Floats | None:
        """Displacement of every pixel's surface point since the frame before; None at first.

        The point that a pixel shows is where its depth says; in the frame before it was there, too, or, of a body that
        moves, where that was. Points at infinity only turn.
        """
        if self.before is None or self.truth is None:
            return None
        now, before = self.now, self.before
        rays = now.camera.rays()[self.first_row : self.first_row + len(self.depth_m)]
        seen = np.isfinite(self.depth_m)
        depth = np.where(seen, self.depth_m, 1.0)
        points = (rays * depth[..., None]) @ now.R_WC.T + seen[..., None] * (now.center_W - before.center_W)
        mover = self.mover_of_geom.take(self._buffers.geom)
        for k, moved in enumerate(now.moving - before.moving):
            points[mover == k, :2] -= moved
        points_C = points @ before.R_WC
        points_C[..., 2] = np.maximum(points_C[..., 2], MIN_DEPTH_RATIO * depth)
        rows, cols = np.indices(depth.shape)
        rows += self.first_row
        flow: Floats = (np.stack([cols, rows], axis=-1) - before.camera.project(points_C)).astype(np.float32)
        return flow


class Retina:
    """Renders a model with MuJoCo's OpenGL renderer into a buffer that no window shows.

    A picture is one pass; its truth another one, in which every pixel has the number of the geom that it shows.
    ``headroom``: how much darker than they are surfaces are lit.
    """

    def __init__(self, model: Any, data: Any, camera: Camera, headroom: float, *, has_shadows: bool) -> None:
        self._mujoco = mujoco = engine.load()
        self._model, self._data, self._headroom = model, data, headroom
        self._camera, self._rows = camera, range(camera.rows)
        self._gl = engine.new_context(camera.cols, camera.rows)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._free = weakref.finalize(self, _free, self._context, self._gl)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 100)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = has_shadows
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_HAZE] = 0
        self._options = mujoco.MjvOption()
        self._options.geomgroup[HULL_GROUP] = 0
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = 0
        # the last entry is that of pixels that show nothing
        self._is_body: Bools = np.append(model.geom_user[:, 0] == BODY, False)
        names = [model.body(body).name for body in model.geom_bodyid]
        numbers = [int(name.removeprefix("moving")) if name.startswith("moving") else -1 for name in names]
        self._mover_of_geom: Ints = np.array([*numbers, -1], np.int32)

    def frame(
        self, now: Eye, before: Eye | None, meanwhile: Sequence[Eye] = (), rows: range | None = None
    ) -> MujocoFrame:
        """Return the frame seen from ``now``, with truth and the flow since ``before`` if that is given.

        ``meanwhile``, ``rows``: as for `Renderer`.
        """
        self._gl.make_current()
        rows = rows or self._rows
        gray = np.zeros((len(rows), self._camera.cols), np.float32)
        for moment in (*meanwhile, now):  # the buffers are those of the last one
            self._place(moment, rows)
            gray += self._picture(gray.shape)
        gray *= np.float32(self._headroom)
        truth = None if before is None else self._truth(gray.shape)
        views = 1 + len(meanwhile)
        return MujocoFrame(gray, views, rows.start, truth, self._is_body, self._mover_of_geom, now, before)

    def close(self) -> None:
        """Free what OpenGL holds, as the end of the process does."""
        self._free()

    def _place(self, eye: Eye, rows: range) -> None:
        """Put camera, lamp and moving bodies where they are at this moment; the state of the physics stays.

        The camera looks at some rows.
        """
        mujoco, data = self._mujoco, self._data
        data.cam_xpos[0] = eye.center_W
        data.cam_xmat[0] = (eye.R_WC * _GL_FROM_C).reshape(-1)
        data.light_xpos[0] = eye.center_W + SUN_M * SUN_W
        if self._model.nlight > 1:
            data.light_xpos[1], data.light_xdir[1] = eye.center_W, eye.R_WC[:, 2]
        for geom in np.flatnonzero(self._mover_of_geom >= 0):
            body = self._model.geom_bodyid[geom]
            move = (*eye.moving[self._mover_of_geom[geom]], 0.0) - data.xpos[body]
            data.geom_xpos[geom] += move
        for k, (x, y) in enumerate(eye.moving):
            data.xpos[self._model.body(f"moving{k}").id] = x, y, 0.0
        mujoco.mjv_updateScene(
            self._model, data, self._options, None, self._view, mujoco.mjtCatBit.mjCAT_ALL.value, self._scene
        )
        if rows == self._rows:
            return
        middle, focal_px = (self._camera.rows - 1) / 2, self._camera.focal_px
        for of_eye in self._scene.camera:
            near = of_eye.frustum_near / focal_px
            of_eye.frustum_top = (middle - rows.start + 0.5) * near
            of_eye.frustum_bottom = (middle - rows.stop + 0.5) * near

    def _picture(self, size: tuple[int, ...]) -> Bytes:
        self._segments(0)
        pixels = np.empty((*size, 3), np.uint8)
        self._draw(pixels, None)
        picture: Bytes = pixels[::-1, :, GREEN]
        return picture

    def _truth(self, size: tuple[int, ...]) -> Buffers:
        mujoco = self._mujoco
        self._segments(1)
        colors, depth = np.empty((*size, 3), np.uint8), np.empty(size, np.float32)
        self._draw(colors, depth)
        geom_of_segment = np.full(self._scene.ngeom + 1, -1, np.int32)
        for shown in self._scene.geoms[: self._scene.ngeom]:
            if shown.segid >= 0 and shown.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                geom_of_segment[shown.segid + 1] = shown.objid
        geom: Ints = geom_of_segment.take(colors[::-1].astype(np.int64) @ _SEGMENT_BASES)
        # OpenGL's projection with the depth reversed: 1 is the near plane, 0 the far one
        depth_m = NEAR_M * FAR_M / (NEAR_M + depth[::-1].astype(np.float64) * (FAR_M - NEAR_M))
        return Buffers(geom, np.where(geom >= 0, depth_m, np.inf).astype(np.float32))

    def _draw(self, colors: Bytes, depth: Floats | None) -> None:
        """Draw the scene into colours, (rows, cols, 3), and its depth, lowest row first."""
        mujoco = self._mujoco
        rect = mujoco.MjrRect(0, 0, colors.shape[1], colors.shape[0])
        mujoco.mjr_render(rect, self._scene, self._context)
        mujoco.mjr_readPixels(colors, depth, rect, self._context)

    def _segments(self, flag: int) -> None:
        flags = self._mujoco.mjtRndFlag
        self._scene.flags[flags.mjRND_SEGMENT] = self._scene.flags[flags.mjRND_IDCOLOR] = flag


def _free(context: Any, gl: Any) -> None:
    gl.make_current()
    context.free()
    gl.free()


def eye_of(camera: Camera, base_W: Doubles, R_WB: Doubles, moving: Doubles) -> Eye:
    """Return the eye of a camera on the mast of a base, ``base_W``: its frame's origin, on the floor."""
    return Eye(camera, base_W + R_WB @ (0.0, 0.0, camera.height_m), R_WB @ camera.R_RC, moving)
