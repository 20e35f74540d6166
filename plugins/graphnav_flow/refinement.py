"""One Lucas-Kanade iteration on one pyramid layer: warp, solve for the flow itself, write it back."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav_flow.pyramid import Plane32
from graphnav_flow.validity import least_eigenvalue

# Derivative of the five-point polynomial; halved, because it is applied to the sum of two images.
_DERIVATIVE = np.array([1, -8, 0, 8, -1], np.float32) / np.float32(24)
_AS_IS = np.ones(1, np.float32)


class Refinement:
    """Improves a displacement field between two images of one size; keeps its buffers from call to call.

    With f0 the field so far, J the source image, I the target image, Jw(x) = J(x + f0(x)) and g the mean gradient of I
    and Jw, it solves, in a window around each pixel, for f itself and not for a correction of f0::

        (sum g g' + e) f = sum g r + e f0      r = g . f0 + I - Jw

    so that f0 may vary inside the window. Where x + f0 leaves the source image, I - Jw is 0: the field is continued.

    Parameters
    ----------
    rows, cols
        Size of the target image and of the field, pixels.
    window_px
        Side of the square window, odd.
    regularization
        e, in (gray / px)^2: draws the field towards f0 where there is little texture.
    zoom
        Source pixels per target pixel (1 or 2); pixel i of the target lies on pixel ``zoom`` * i of the source.
    """

    def __init__(self, rows: int, cols: int, window_px: int, regularization: float, zoom: int = 1) -> None:
        self._window = (window_px, window_px)
        self._regularization, self._zoom = regularization, zoom
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._right, self._down = zoom * right, zoom * down
        (
            self._map_u, self._map_v, self._warped, self._gu, self._gv, self._r, self._term,
            self._uu, self._uv, self._vv, self._ur, self._vr, self._det,
        ) = np.empty((13, rows, cols), np.float32)  # fmt: skip

    def improve(self, target: Plane32, source: Plane32, u: Plane32, v: Plane32) -> None:
        """Write the improved field over ``u`` and ``v``: target pixel x is found at x + (u, v) in the source."""
        self._warp(target, source, u, v)
        self._linearize(target, u, v)
        self._sum_windows(u, v)
        self._solve(u, v)

    def texture(self) -> Plane32:
        """Return the smaller eigenvalue of the last windows' structure tensor, (gray / px)^2, shape (rows, cols)."""
        return least_eigenvalue(self._uu, self._uv, self._vv)

    def _warp(self, target: Plane32, source: Plane32, u: Plane32, v: Plane32) -> None:
        cv2.scaleAdd(u, self._zoom, self._right, dst=self._map_u)
        cv2.scaleAdd(v, self._zoom, self._down, dst=self._map_v)
        np.copyto(self._warped, target)
        cv2.remap(
            source, self._map_u, self._map_v, cv2.INTER_LINEAR, dst=self._warped, borderMode=cv2.BORDER_TRANSPARENT
        )

    def _linearize(self, target: Plane32, u: Plane32, v: Plane32) -> None:
        cv2.add(target, self._warped, dst=self._term)
        cv2.sepFilter2D(self._term, -1, _DERIVATIVE, _AS_IS, dst=self._gu)
        cv2.sepFilter2D(self._term, -1, _AS_IS, _DERIVATIVE, dst=self._gv)
        cv2.subtract(target, self._warped, dst=self._r)
        cv2.accumulateProduct(self._gu, u, self._r)
        cv2.accumulateProduct(self._gv, v, self._r)

    def _sum_windows(self, u: Plane32, v: Plane32) -> None:
        products = (
            (self._gu, self._gu, self._uu),
            (self._gu, self._gv, self._uv),
            (self._gv, self._gv, self._vv),
            (self._gu, self._r, self._ur),
            (self._gv, self._r, self._vr),
        )
        for one, other, out in products:
            cv2.multiply(one, other, dst=self._term)
            cv2.blur(self._term, self._window, dst=out, borderType=cv2.BORDER_CONSTANT)
        self._uu += self._regularization
        self._vv += self._regularization
        cv2.scaleAdd(u, self._regularization, self._ur, dst=self._ur)
        cv2.scaleAdd(v, self._regularization, self._vr, dst=self._vr)

    def _solve(self, u: Plane32, v: Plane32) -> None:
        """Write the solution of [[uu, uv], [uv, vv]] (u, v) = (ur, vr), by Cramer's rule."""
        term, det = self._term, self._det
        np.multiply(self._uu, self._vv, out=det)
        np.multiply(self._uv, self._uv, out=term)
        np.subtract(det, term, out=det)
        np.multiply(self._vv, self._ur, out=u)
        np.multiply(self._uv, self._vr, out=term)
        np.subtract(u, term, out=u)
        np.divide(u, det, out=u)
        np.multiply(self._uu, self._vr, out=v)
        np.multiply(self._uv, self._ur, out=term)
        np.subtract(v, term, out=v)
        np.divide(v, det, out=v)
