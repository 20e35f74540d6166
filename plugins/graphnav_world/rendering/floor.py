"""The floor in the picture: its texture at every pixel, as if there were no bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from graphnav.arrays import Doubles, Floats, Indices
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.mip import mip_levels
from graphnav_world.rendering.placed_faces import Placed

SKY_GRAY = 255


class Floor:
    """Draws the floor; ``origin_m``: the world point where its texture begins.

    What follows from the camera's tilt, roll and height alone is computed once for the camera at rest, and again for
    every frame of a camera that shakes.
    """

    def __init__(self, camera: Camera, atlas: Atlas, origin_m: Doubles) -> None:
        self._atlas, self._origin_m = atlas, origin_m
        self._at_rest = self._shaken = FloorView.of(camera, atlas)

    def inverse_depth(self, now: Placed, rows: range | None = None) -> Floats:
        """Return 1/m along the optical axis, float32 (rows, cols), 0 above the horizon; of some rows or of all."""
        inverse_depth = self._view(now).inverse_depth
        return inverse_depth if rows is None else inverse_depth[rows.start : rows.stop]

    def gray(self, now: Placed, rows: range | None = None) -> Floats:
        """Return the gray values before light and noise, float32 (rows, cols), of some rows or of all."""
        view = self._view(now)
        if rows is not None:
            view = view.part(rows)
        fine_px, coarse_px = self._places(now, view)
        fine = cv2.remap(self._atlas.pixels, fine_px, None, cv2.INTER_LINEAR)
        coarse = cv2.remap(self._atlas.pixels, coarse_px, None, cv2.INTER_LINEAR)
        gray: Floats = cv2.subtract(coarse, fine, dtype=cv2.CV_32F)
        gray *= view.blend
        gray += fine
        if len(view.sky):
            gray.reshape(-1)[view.sky] = SKY_GRAY
        return gray

    def _view(self, now: Placed) -> FloorView:
        if now.camera == self._at_rest.camera:
            return self._at_rest
        if now.camera != self._shaken.camera:
            self._shaken = FloorView.of(now.camera, self._atlas)
        return self._shaken

    def _places(self, now: Placed, view: FloorView) -> tuple[Floats, Floats]:
        """Return the atlas position of every pixel's floor point, (rows, cols, 2), on the finer and coarser level."""
        c, s = now.heading
        period = self._atlas.period_m[0]
        x, y = (now.eye_W[:2] - self._origin_m) % period
        place: Floats = cv2.transform(view.place_R, np.array([[c, -s, x], [s, c, y]]))
        reach_m = view.reach_m
        if min(x, y) < reach_m or x + reach_m > period[0] or y + reach_m > period[1]:
            place -= np.floor(place / period) * period
        place *= view.per_m
        place += view.fine_px
        coarse = place * np.float32(0.5)
        coarse += view.coarse_px
        return place, coarse


@dataclass(frozen=True)
class FloorView:
    """Where the pixels of a camera of one tilt, roll and height show the floor, and on which texels.

    It is relative to the robot, and holds wherever the robot is.

    ``inverse_depth``: float32 (rows, cols), 1/m along the optical axis, 0 above the horizon. ``sky``: flat indices of
    pixels above it. ``place_R``: floor points in R, (rows, cols, 2), at most ``reach_m`` away. ``blend``: share of the
    coarser mip level, (rows, cols). ``per_m``: texels, and ``fine_px``, ``coarse_px``: origins in the atlas, of the
    finer and the coarser level, (rows, cols, 2).
    """

    camera: Camera
    inverse_depth: Floats
    sky: Indices
    place_R: Floats  # noqa: N815  # the frame's letter
    reach_m: float
    blend: Floats
    per_m: Floats
    fine_px: Floats
    coarse_px: Floats

    def part(self, rows: range) -> FloorView:
        """Return the view of some rows."""
        cut = slice(rows.start, rows.stop)
        inverse = self.inverse_depth[cut]
        return replace(
            self,
            inverse_depth=inverse,
            sky=np.flatnonzero(inverse <= 0),
            place_R=self.place_R[cut],
            blend=self.blend[cut],
            per_m=self.per_m[cut],
            fine_px=self.fine_px[cut],
            coarse_px=self.coarse_px[cut],
        )

    @classmethod
    def of(cls, camera: Camera, atlas: Atlas) -> FloorView:
        """Return the view of a camera on the floor, the first texture of the atlas."""
        rays_R = camera.rays() @ camera.R_RC.T
        inverse = np.maximum(-rays_R[..., 2] / camera.height_m, 0.0).astype(np.float32)
        depth = np.reciprocal(np.maximum(inverse, np.float32(1e-3)))
        place_R: Floats = np.ascontiguousarray(rays_R[..., :2].astype(np.float32) * depth[..., None])
        length_ratio = depth * np.square(rays_R).sum(axis=-1).astype(np.float32) / np.float32(camera.height_m)
        level, blend = mip_levels(depth.reshape(-1), length_ratio.reshape(-1), camera, atlas.levels)
        shape = place_R.shape
        fine_px, coarse = (atlas.origin_px[0, one].reshape(shape) for one in (level, level + 1))
        per_m: Floats = np.reciprocal(atlas.texel_m).take(level).repeat(2).reshape(shape)
        return cls(
            camera=camera,
            inverse_depth=inverse,
            sky=np.flatnonzero(inverse <= 0),
            place_R=place_R,
            reach_m=float(np.linalg.norm(place_R, axis=-1).max()),
            blend=blend.reshape(inverse.shape),
            per_m=per_m,
            fine_px=fine_px,
            coarse_px=coarse - fine_px * np.float32(0.5),
        )
