"""Dense optical flow by pyramidal Lucas-Kanade as published, without refinements."""

from __future__ import annotations

from typing import Literal

import cv2
import numpy as np

from graphnav import Flow, Image, Stage, Stamp, param
from graphnav.arrays import Doubles
from graphnav_flow.frames import Frames
from graphnav_flow.pyramid import Pyramid
from graphnav_flow.validity import MARGIN_DOC, MARGIN_PX, MIN_TEXTURE_DOC, MIN_TEXTURE_GRAY2, Validity

_SINGULAR = 1e-9
"""Determinant of the structure tensor, as a share of its squared trace, up to which it has no inverse."""
_FIVE_POINT = np.array([[1, -8, 0, 8, -1]]) / 12


class PlainLucasKanade(Stage):
    """Dense optical flow by pyramidal Lucas-Kanade, as [OI, Algorithm 1] prints it.

    On a pyramid of K layers above the base, from the coarsest layer down: upsample the flow found so far (zero at the
    start), warp the second image by it, solve Lucas-Kanade once in a window around every pixel, add the correction.
    With ``g`` the gradient of the first image I, Jw the warped second one and sums over the window::

        (sum g g') d = sum g (Jw - I)

    Nothing is smoothed, filtered or regularized; `flow.lucas_kanade` is what became of it. Validity follows the rule of
    all estimators; ``{margin_px: 0, min_texture_gray2: 0}`` lets every vector count, as in the paper.

    The paper leaves open, and here holds: windows of 5x5 pixels, cut off at the border; layers made by the 5x5 binomial
    filter; bilinear interpolation; beyond the border the nearest pixel; no correction where the matrix has no inverse.
    The first image is the newer one, as for all estimators here: the flow lives on the newest frame.

    The first image gives no flow, nor does the first after a gap of more than 3 periods. Without texture a correction
    may be as large as the picture.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       Algorithm 1.
    """

    layers: int = param(3, ge=0, le=8, doc="K, layers above the base; an image too small for them gets fewer")
    window_radius_px: int = param(2, ge=1, le=30, doc="extent of the window to each side")
    iterations: int = param(1, ge=1, le=20, doc="warps and corrections per layer; 1 as in [OI]")
    differences: Literal["central", "five_point"] = param(
        "central",
        doc="gradient: central differences of the first image; five_point: the derivative of the five-point "
        "polynomial, of the mean of the first image and the warped second one",
    )
    median_px: int = param(1, ge=1, le=5, doc="side of the median filter after each layer (odd); 1 is none, as in [OI]")
    smooth_px: int = param(
        1, ge=1, le=31, doc="side of the box that averages the flow after each layer (odd); 1 is none, as in [OI]"
    )
    margin_px: float = param(MARGIN_PX, ge=0.0, le=100_000.0, doc=MARGIN_DOC)
    min_texture_gray2: float = param(MIN_TEXTURE_GRAY2, ge=0.0, le=1e6, doc=MIN_TEXTURE_DOC)

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget the last image."""
        self._frames = Frames()
        self._validity = Validity(self.margin_px, self.min_texture_gray2)
        self._pyramids: list[Pyramid] = []

    def step(self, image: Image, stamp: Stamp) -> Flow | None:
        """Return the flow since the last image, None without one."""
        gray, interval_us = self._frames.next(image, stamp)
        if not self._pyramids:
            rows, cols = gray.shape
            self._pyramids = [Pyramid(rows, cols, self.layers) for _ in range(2)]
        self._pyramids.reverse()
        now, last = self._pyramids
        now.fill(gray)
        if not interval_us:
            return None
        flow = np.zeros((*now.layers[-1].shape, 2))
        for first, second in zip(reversed(now.layers), reversed(last.layers), strict=True):
            flow = self._layer(first.astype(np.float64), second.astype(np.float64), flow)
        uv_px = flow.astype(np.float32)
        return Flow(uv_px=uv_px, valid=self._validity.mark(uv_px, now.layers[0]), interval_us=interval_us)

    def _layer(self, first: Doubles, second: Doubles, above: Doubles) -> Doubles:
        """Return the flow on a layer from that on the layer above (or, on the coarsest layer, from zero)."""
        y, x = np.mgrid[: first.shape[0], : first.shape[1]].astype(np.float64)
        flow = 2 * bilinear(above, x / 2, y / 2) if above.shape[:2] != first.shape else above
        for _ in range(self.iterations):
            warped = bilinear(second, x - flow[..., 0], y - flow[..., 1])
            flow = flow + self._correction(first, warped)
        return self._filtered(flow)

    def _correction(self, first: Doubles, warped: Doubles) -> Doubles:
        """Return d, (rows, cols, 2), 0 where the structure tensor has no inverse."""
        gu, gv = self._gradient(first, warped)
        uu, uv, vv, ud, vd = (
            self._window_sum(product)
            for product in (gu * gu, gu * gv, gv * gv, gu * (warped - first), gv * (warped - first))
        )
        determinant = uu * vv - uv * uv
        solvable = determinant > _SINGULAR * (uu + vv) ** 2
        divisor = np.where(solvable, determinant, np.inf)
        return np.stack([(vv * ud - uv * vd) / divisor, (uu * vd - uv * ud) / divisor], axis=-1)

    def _gradient(self, first: Doubles, warped: Doubles) -> tuple[Doubles, Doubles]:
        if self.differences == "central":
            along_column, along_row = np.gradient(first)
            return np.asarray(along_row), np.asarray(along_column)
        mean = (first + warped) / 2
        return cv2.filter2D(mean, -1, _FIVE_POINT), cv2.filter2D(mean, -1, _FIVE_POINT.T)

    def _window_sum(self, values: Doubles) -> Doubles:
        side = 2 * self.window_radius_px + 1
        total: Doubles = cv2.boxFilter(values, -1, (side, side), normalize=False, borderType=cv2.BORDER_CONSTANT)
        return total

    def _filtered(self, flow: Doubles) -> Doubles:
        if self.median_px > 1:
            planes = [np.ascontiguousarray(flow[..., channel], np.float32) for channel in range(2)]
            flow = np.stack([cv2.medianBlur(plane, self.median_px | 1) for plane in planes], axis=-1).astype(np.float64)
        if self.smooth_px > 1:
            flow = cv2.blur(flow, (self.smooth_px | 1, self.smooth_px | 1))
        return flow


def bilinear(values: Doubles, x: Doubles, y: Doubles) -> Doubles:
    """Return ``values`` (rows, cols, ...) at columns ``x`` and rows ``y``, both (m, n).

    Exactly bilinear, where OpenCV rounds places to 1/32 pixel. Beyond the border the nearest pixel counts.
    """
    rows, cols = values.shape[:2]
    x, y = np.clip(x, 0, cols - 1), np.clip(y, 0, rows - 1)
    left, top = np.minimum(x.astype(np.intp), cols - 2), np.minimum(y.astype(np.intp), rows - 2)
    right_share, low_share = x - left, y - top
    lines = values.reshape(rows * cols, -1)
    first = top * cols + left
    sampled = np.zeros((*x.shape, lines.shape[1]))
    for offset, share in (
        (0, (1 - right_share) * (1 - low_share)),
        (1, right_share * (1 - low_share)),
        (cols, (1 - right_share) * low_share),
        (cols + 1, right_share * low_share),
    ):
        sampled += share[..., None] * lines[first + offset]
    return sampled.reshape(*x.shape, *values.shape[2:])
