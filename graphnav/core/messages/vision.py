"""Messages of cameras and of what is computed from their images.

Arrays have rows (down) first and columns (right) second. In a grid of step ``step_px``, cell (r, c) covers the
block of pixels whose top left pixel is (r * step_px, c * step_px).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import graphnav_lcm
import numpy as np

from graphnav.arrays import Bools, Bytes, Doubles, Floats
from graphnav.core.messages.message import ZERO_MEANS, FieldError, Message, may_be_infinite


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
        """Return the picture whose flat bytes ``image_t`` holds; a ``step_px`` of 0 is read as 1.

        Raises
        ------
        FieldError
            A size is not positive, there are neither 1 nor 3 channels, or the size of the data is another one.
        """
        rows, cols, channels, data = values["rows"], values["cols"], values["channels"], np.asarray(values["data"])
        for name in ("rows", "cols"):
            if values[name] < 1:
                raise FieldError(name, values[name], "1 or more")
        if channels not in (1, 3):
            raise FieldError("channels", channels, "1 (gray) or 3 (red-green-blue)")
        if data.size != rows * cols * channels:
            product = f"{rows} * {cols} * {channels} = {rows * cols * channels}"
            raise FieldError("size", data.size, f"rows * cols * channels = {product}")
        shape = (rows, cols) if channels == 1 else (rows, cols, channels)
        return cls(pixels=data.reshape(shape), step_px=values["step_px"] or ZERO_MEANS["step_px"])


class CameraInfo(Message, lcm=graphnav_lcm.camera_info_t):
    """Intrinsic parameters of a camera, as its driver publishes them: those of ROS ``sensor_msgs/CameraInfo``.

    ``rows``, ``cols``: size of the pictures that were calibrated. ``model``: "plumb_bob" or "rational_polynomial" of a
    pinhole, "equidistant" of a fisheye. ``camera``: float64 (3, 3), focal lengths and principal point, pixels.
    ``distortion``: float64 (n,), in OpenCV's order: 4, 5 or 8 numbers, 4 of a fisheye; none of a camera that does not
    distort. ``rectification``: float64 (3, 3), from the camera to the rectified one. ``projection``: float64 (3, 4),
    the camera matrix of the rectified one.
    """

    MODELS: ClassVar[Mapping[str, tuple[int, ...]]] = {
        "plumb_bob": (0, 4, 5),
        "rational_polynomial": (0, 8),
        "equidistant": (4,),
    }
    """The numbers of distortion coefficients that each model may have."""

    rows: int
    cols: int
    model: str
    camera: Doubles
    distortion: Doubles
    rectification: Doubles
    projection: Doubles

    @classmethod
    def from_lcm_fields(cls, values: Mapping[str, Any]) -> Self:
        """Return the parameters of ``camera_info_t``.

        Raises
        ------
        FieldError
            The model is not known, has not so many coefficients, or the camera is not calibrated.
        """
        found = super().from_lcm_fields(values)
        if found.model not in cls.MODELS:
            raise FieldError("model", repr(found.model[:40]), ", ".join(cls.MODELS))
        counts = cls.MODELS[found.model]
        if found.distortion.size not in counts:
            raise FieldError("size of distortion", found.distortion.size, f"{' or '.join(map(str, counts))} numbers")
        if not (found.camera[0, 0] > 0.0 and found.camera[1, 1] > 0.0):
            raise FieldError("focal length", f"{found.camera[0, 0]:g}", "more than 0: calibrate the camera")
        return found


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


class FlowDeviation(Message, lcm=graphnav_lcm.flow_deviation_t, grid=("deviation_px",)):
    """How far the vectors of a flow are likely to be off, by the pictures alone.

    ``deviation_px``: float32 (rows, cols), the predicted root mean square length of the error, pixels per frame.
    """

    deviation_px: Floats
    step_px: int = 1

    def at(self, shape: tuple[int, ...], step_px: int) -> Floats:
        """Return the deviation at the middle of every cell of another grid of the same picture, (rows, cols)."""
        own = self.deviation_px.shape
        rows, cols = (
            np.minimum((2 * np.arange(n) + 1) * step_px // (2 * self.step_px), m - 1)
            for n, m in zip(shape, own, strict=True)
        )
        return self.deviation_px if own == shape and step_px == self.step_px else self.deviation_px[np.ix_(rows, cols)]

    def sureness_at(self, shape: tuple[int, ...], step_px: int, full_px: float) -> Floats:
        """Return how much every cell of another grid counts, float32 (rows, cols), above 0 up to 1.

        It is 1 where the deviation is at most ``full_px``, and the ratio of both elsewhere: errors weighed by it have
        the same size everywhere.
        """
        full = np.float32(full_px)
        return np.asarray(full / np.maximum(self.at(shape, step_px), full), np.float32)

    def known_ratio(self, max_px: float, rim_ratio: float) -> float:
        """Return the share of the picture inside the rim of `Plane.unknown` where it is at most ``max_px``, 0 to 1."""
        rows, cols = _inside_rim(self.deviation_px.shape, rim_ratio)
        inner = self.deviation_px[rows, cols]
        return int(np.count_nonzero(inner <= max_px)) / max(inner.size, 1)


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
    ``valid``: uint8 (rows, cols), 1 where the cell was judged; elsewhere ``obstacle`` is 0, which does not mean free:
    see `unknown`.
    ``obstacle_ratio``: share of obstacle among the valid cells.
    ``converged``: whether an iterative detector converged; true for the others.
    """

    RIM_RATIO: ClassVar[float] = 0.17
    """The default width of the rim, a share of the picture's shorter side: in the drives of the shipped graphs all
    cells farther inside are judged, also in their fastest turns."""

    obstacle: Bytes
    score: Floats
    valid: Bytes
    step_px: int
    obstacle_ratio: float
    threshold: float = 0.0
    converged: bool = True

    def unknown(self, rim_ratio: float = RIM_RATIO) -> Bools:
        """Return the cells that were not judged for lack of texture, bool (rows, cols).

        Near the border of the picture flow is never valid: windows reach out of the picture, and what has just moved
        into view was not seen before. Cells whose centre is nearer to the border than ``rim_ratio`` times the shorter
        side of the grid (0 to 0.4) are this rim. Inside it, every cell that was not judged is unknown: it has no
        texture, as a white wall, it reflects, or it is above the horizon, and it may be an obstacle. A cell of the rim
        that was not judged is unknown if the nearest cell inside the rim is: what fills the picture's upper half
        reaches up to the border.
        """
        unjudged = self.valid == 0
        rows, cols = _inside_rim(unjudged.shape, rim_ratio)
        inner = unjudged[rows, cols]
        if not inner.any():
            return np.zeros_like(unjudged)
        rim_rows, rim_cols = ((all_ - left) // 2 for all_, left in zip(unjudged.shape, inner.shape, strict=True))
        extended: Bools = np.pad(inner, ((rim_rows, rim_rows), (rim_cols, rim_cols)), mode="edge")
        extended &= unjudged
        return extended

    def unknown_ratio(self, rim_ratio: float = RIM_RATIO) -> float:
        """Return the share of unknown cells among the cells inside the rim, 0 to 1; 0 for a grid without cells."""
        rows, cols = _inside_rim(self.valid.shape, rim_ratio)
        inner = self.valid[rows, cols]
        return (inner.size - int(np.count_nonzero(inner))) / max(inner.size, 1)


def _inside_rim(shape: tuple[int, ...], rim_ratio: float) -> tuple[slice, slice]:
    """Return the rows and columns of the cells whose centre is inside the rim of `Plane.unknown`."""
    rows, cols = shape
    rim_cells = max(math.ceil(rim_ratio * min(rows, cols) - 0.5), 0)
    return slice(rim_cells, rows - rim_cells), slice(rim_cells, cols - rim_cells)


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
