"""Messages of cameras and of what is computed from their images.

Arrays have rows (down) first and columns (right) second. In a grid of step ``step_px``, cell (r, c) covers the
block of pixels whose top left pixel is (r * step_px, c * step_px).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import graphnav_lcm
import numpy as np

from graphnav.arrays import Bytes, Doubles, Floats
from graphnav.messages.message import Message, may_be_infinite


class Image(Message, lcm=graphnav_lcm.image_t, grid=("pixels",)):
    """A picture.

    ``pixels``: uint8, (rows, cols) gray or (rows, cols, 3) red-green-blue.
    """

    pixels: Bytes
    step_px: int = 1

    def lcm_fields(self) -> Mapping[str, Any]:
        """Return the pixels as the flat bytes of ``image_t``."""
        rows, cols = self.pixels.shape[:2]
        channels = 1 if self.pixels.ndim == 2 else self.pixels.shape[2]
        data = self.pixels.reshape(-1)
        return {"step_px": self.step_px, "rows": rows, "cols": cols, "channels": channels, "data": data}

    @classmethod
    def from_lcm_fields(cls, values: Mapping[str, Any]) -> Self:
        """Return the picture whose flat bytes ``image_t`` holds."""
        rows, cols, channels = values["rows"], values["cols"], values["channels"]
        if rows < 1 or cols < 1 or channels not in (1, 3):
            raise ValueError(f"an image of {cols}x{rows} pixels and {channels} channels")
        shape = (rows, cols) if channels == 1 else (rows, cols, channels)
        return cls(pixels=np.asarray(values["data"]).reshape(shape), step_px=values["step_px"])


class Flow(Message, lcm=graphnav_lcm.flow_t, grid=("uv_px", "valid")):
    """Optical flow: the displacement since the last frame of the point now seen at each position.

    ``uv_px``: float32 (rows, cols, 2), right and down, pixels per frame, finite everywhere.
    ``valid``: uint8 (rows, cols), 1 where the vector is reliable.
    ``interval_us``: the time that the displacement covers.
    """

    uv_px: Floats
    valid: Bytes
    interval_us: int
    step_px: int = 1


class Planar(Message, lcm=graphnav_lcm.planar_t, grid=("planar_uv_px", "planar_valid", "residual_px")):
    """The flow that an obstacle-free ground would give for the motion of this frame.

    ``planar_uv_px``: float32 (rows, cols, 2), right and down, pixels per frame.
    ``planar_valid``: uint8 (rows, cols), 1 where the model was taught.
    ``residual_px``: float32 (rows, cols), root mean square error of the model.
    """

    planar_uv_px: Floats
    planar_valid: Bytes
    residual_px: Floats
    interval_us: int
    step_px: int = 1


class Plane(Message, lcm=graphnav_lcm.plane_t, grid=("obstacle", "score", "valid")):
    """The dominant plane: the segmentation into ground and obstacle.

    ``obstacle``: uint8 (rows, cols), the dominant map d of [OI]: 0 on the ground plane, 1 elsewhere.
    ``score``: float32 (rows, cols), higher is more obstacle; ``threshold``: cells above are obstacle.
    ``valid``: uint8 (rows, cols), 1 where the cell was judged; elsewhere ``obstacle`` is 0.
    ``obstacle_ratio``: share of obstacle among the valid cells.
    ``converged``: whether an iterative detector converged; true for the others.
    """

    obstacle: Bytes
    score: Floats
    valid: Bytes
    step_px: int
    obstacle_ratio: float
    threshold: float = 0.0
    converged: bool = True


class Components(Message, lcm=graphnav_lcm.components_t, grid=("alpha", "beta", "valid")):
    """The independent components of a flow and its planar flow [OI, eq. 2], ordered by the variance of their length.

    ``alpha``, ``beta``: float32 (rows, cols, 2), right and down, of unit variance: v_alpha, whose length varies less,
    and v_beta. Their signs are arbitrary.
    ``mixing``: float64 (2, 2), the coefficients a_ij: flow = a_00 v_alpha + a_01 v_beta, and planar flow =
    a_10 v_alpha + a_11 v_beta, in pixels.
    ``variances``: float64 (2,), of the lengths of v_alpha and v_beta over the valid cells.
    ``taken``: which of them the obstacle score is made from, 0 or 1.
    ``valid``: uint8 (rows, cols), 1 where the cell was separated.
    """

    alpha: Floats
    beta: Floats
    mixing: Doubles
    variances: Doubles
    taken: int
    valid: Bytes
    step_px: int


class Potential(Message, lcm=graphnav_lcm.potential_t, grid=("potential", "gradient")):
    """The obstacle potential and its gradient, on the grid of the plane that it was made from.

    ``potential``: float32 (rows, cols). ``gradient``: float32 (rows, cols, 2), right and down, per cell; it points
    towards the obstacle.
    """

    potential: Floats
    gradient: Floats
    step_px: int


class Truth(Message, lcm=graphnav_lcm.truth_t, grid=("obstacle", "depth_m", "flow_px")):
    """Ground truth of a frame from the simulator; for scores and oracles only.

    ``obstacle``: uint8 (rows, cols), 1 where an obstacle is visible; 0 on the ground plane and above the horizon.
    ``depth_m``: float32 (rows, cols) along the optical axis, infinite above the horizon, finite elsewhere.
    ``flow_px``: float32 (rows, cols, 2), as in `Flow`, including points that were hidden or outside before.
    """

    is_truth: ClassVar[bool] = True

    obstacle: Bytes
    depth_m: Floats = may_be_infinite()
    flow_px: Floats
    interval_us: int
    step_px: int = 1


class PlanarModel(Message, lcm=graphnav_lcm.planar_model_t):
    """A taught planar flow model: basis fields, combined by the motion of a frame.

    ``terms``: the factor of each field: "mean" (1), "v" (forward_m), "w" (turn_rad), "vw", "ww"; "c1", "c2", ...:
    principal components, whose factors are fitted to each frame (root mean square 1 when taught).
    ``basis``: float32 (terms, rows, cols, 2). ``valid``: uint8 (rows, cols). ``residual_px``: float32 (rows, cols),
    root mean square residual of the taught flow.
    ``forward_range_m``, ``turn_range_rad``: float64 (2,), minimum and maximum taught motion per frame.
    """

    terms: tuple[str, ...]
    basis: Floats
    valid: Bytes
    residual_px: Floats
    forward_range_m: Doubles
    turn_range_rad: Doubles
    frames: int
    interval_us: int
    step_px: int
