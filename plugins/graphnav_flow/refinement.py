"""A Lucas-Kanade iteration on one pyramid layer: smooth, warp, solve for a correction."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats

# Derivative of the five-point polynomial; halved, because it is applied to the sum of two images.
_DERIVATIVE = np.array([[1, -8, 0, 8, -1]], np.float32) / np.float32(24)


class Refinement:
    """Improves a displacement field between two images of one size; reuses its buffers.

    With f0 the smoothed field so far, J the source image, I the target image, Jw(x) = J(x + f0(x)) and g the mean
    gradient of I and Jw, it solves in a window around each pixel for the correction d::

        (sum g g' + e) d = sum g (I - Jw)        f = f0 + d

    Without smoothing first, every correction adds noise that later ones do not remove. Smoothing f0 instead of d makes
    a linearly varying field, as that of a plane nearly is, a fixed point; a larger window would bias it toward texture.
    Where x + f0 leaves the source image, I - Jw is 0: the field is continued.

    Parameters
    ----------
    rows, cols
        Size of the target image and of the field, pixels.
    window_px
        Side of the square window, odd.
    smooth_px
        Side of the box that smooths the field.
    regularization_gray2
        e, in (gray / px)^2: pulls the correction to 0 where there is little texture.
    zoom
        Source pixels per target pixel (1 or 2); pixel i of the target lies on pixel ``zoom`` * i of the source.
    """

    def __init__(
        self, rows: int, cols: int, *, window_px: int, smooth_px: int, regularization_gray2: float, zoom: int
    ) -> None:
        self._window, self._box = (window_px, window_px), (smooth_px, smooth_px)
        self._regularization_gray2, self._zoom = regularization_gray2, zoom
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._right, self._down = zoom * right, zoom * down
        (
            self._map_u, self._map_v, self._warped, self._gu, self._gv, self._difference, self._term, self._other,
            self._uu, self._uv, self._vv, self._ud, self._vd,
        ) = np.empty((13, rows, cols), np.float32)  # fmt: skip

    def improve(self, target: Floats, source: Floats, u: Floats, v: Floats) -> None:
        """Write the improved field over ``u`` and ``v``: target pixel x is found at x + (u, v) in the source."""
        cv2.blur(u, self._box, dst=u)
        cv2.blur(v, self._box, dst=v)
        self._warp(target, source, u, v)
        self._linearize(target)
        self._sum_windows()
        self._correct(u, v)

    def _warp(self, target: Floats, source: Floats, u: Floats, v: Floats) -> None:
        cv2.scaleAdd(u, self._zoom, self._right, dst=self._map_u)
        cv2.scaleAdd(v, self._zoom, self._down, dst=self._map_v)
        np.copyto(self._warped, target)
        cv2.remap(
            source, self._map_u, self._map_v, cv2.INTER_LINEAR, dst=self._warped, borderMode=cv2.BORDER_TRANSPARENT
        )

    def _linearize(self, target: Floats) -> None:
        cv2.add(target, self._warped, dst=self._term)
        cv2.filter2D(self._term, -1, _DERIVATIVE, dst=self._gu)
        cv2.filter2D(self._term, -1, _DERIVATIVE.T, dst=self._gv)
        cv2.subtract(target, self._warped, dst=self._difference)

    def _sum_windows(self) -> None:
        products = (
            (self._gu, self._gu, self._uu),
            (self._gu, self._gv, self._uv),
            (self._gv, self._gv, self._vv),
            (self._gu, self._difference, self._ud),
            (self._gv, self._difference, self._vd),
        )
        for one, other, out in products:
            cv2.multiply(one, other, dst=self._term)
            cv2.blur(self._term, self._window, dst=out, borderType=cv2.BORDER_CONSTANT)
        self._uu += self._regularization_gray2
        self._vv += self._regularization_gray2

    def _correct(self, u: Floats, v: Floats) -> None:
        """Add the solution of [[uu, uv], [uv, vv]] d = (ud, vd), by Cramer's rule."""
        term, other = self._term, self._other
        np.multiply(self._uu, self._vv, out=other)
        np.multiply(self._uv, self._uv, out=term)
        per_det = np.divide(1, np.subtract(other, term, out=other), out=self._map_u)
        for field, own, right, left in ((u, self._vv, self._ud, self._vd), (v, self._uu, self._vd, self._ud)):
            np.multiply(own, right, out=other)
            np.multiply(self._uv, left, out=term)
            np.subtract(other, term, out=other)
            cv2.accumulateProduct(other, per_det, field)
