"""The pixels of a camera on the floor, relative to the robot: independent of where it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Floats, Indices
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.mip import mip_levels


@dataclass(frozen=True)
class FloorView:
    """Where the pixels of a camera of one tilt, roll and height show the floor, and on which texels.

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
