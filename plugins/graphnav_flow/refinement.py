"""A Lucas-Kanade iteration on one pyramid layer: warp, linearize, solve for a correction."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats

# Derivative of the five-point polynomial; halved, because it is applied to the sum of two images.
_ALONG_ROW = np.array([[1, -8, 0, 8, -1]], np.float32) / np.float32(24)
_ALONG_COLUMN = _ALONG_ROW.T.copy()


class Refinement:
    """Improves a displacement field between two images of one size; reuses its buffers.

    With f0 the smoothed field so far, J the source image, I the target image, Jw(x) = J(x - f0(x)) and g the mean
    gradient of I and Jw, it solves in a window around each pixel for the correction d::

        (sum g g' + e) d = sum g (Jw - I)        f = f0 + d

    Without smoothing first, every correction adds noise that later ones do not remove. Smoothing f0 instead of d makes
    a linearly varying field, as that of a plane nearly is, a fixed point; a larger window would bias it toward texture.
    Where x - f0 leaves the source image, Jw - I is 0: the field is continued.

    ``planes``: the field, one float32 (rows, cols) for u and one for v; the caller writes f0 and reads f there.

    Parameters
    ----------
    rows, cols
        Size of the target image and of the field, pixels.
    window_px
        Side of the square window, odd.
    regularization_gray2
        e, in (gray / px)^2: pulls the correction to 0 where there is little texture.
    zoom
        Source pixels per target pixel (1 or 2); pixel i of the target lies on pixel ``zoom`` * i of the source.
    """

    def __init__(self, rows: int, cols: int, *, window_px: int, regularization_gray2: float, zoom: int) -> None:
        self._regularization_gray2, self._zoom = regularization_gray2, zoom
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._places = zoom * np.concatenate([right, down])
        # One image of twice the rows for both directions takes half the calls.
        self._field, self._map = np.zeros((2, 2 * rows, cols), np.float32)
        self.planes = (self._field[:rows], self._field[rows:])
        self._map_u, self._map_v = self._map[:rows], self._map[rows:]
        self._warped, self._difference, self._total, self._ratio, self._step = np.empty((5, rows, cols), np.float32)
        self._g = np.empty((2, rows, cols), np.float32)
        self._gu, self._gv = self._g
        self._kernel = np.full((1, window_px), 1 / window_px, np.float32)
        # Products below each other, half a window of zeros apart: one filter sums several.
        pitch = rows + window_px // 2
        self._products, self._sums = np.zeros((2, 5 * pitch, cols), np.float32)
        products = self._products.reshape(5, pitch, cols)[:, :rows]
        self._squares, self._uv, self._gd = products[:2], products[2], products[3:]
        self._sum_planes = tuple(self._sums.reshape(5, pitch, cols)[:, :rows])
        self._diagonal, self._others, self._right_side = np.s_[: 2 * pitch], np.s_[2 * pitch :], np.s_[3 * pitch :]

    def improve(self, target: Floats, source: Floats, *, keep_tensor: bool = False) -> None:
        """Add the correction to the field: target pixel x is found at x - (u, v) in the source.

        ``keep_tensor``: take the structure tensor sum g g' of the last call.
        """
        self._warp(target, source)
        self._linearize(target)
        if keep_tensor:
            self._sum_windows(self._right_side)
        else:
            np.multiply(self._g, self._g, out=self._squares)
            np.multiply(self._gu, self._gv, out=self._uv)
            self._sum_windows(self._diagonal, self._regularization_gray2)
            self._sum_windows(self._others)
            self._decompose()
        self._correct()

    def _warp(self, target: Floats, source: Floats) -> None:
        cv2.addWeighted(self._field, -self._zoom, self._places, 1, 0, dst=self._map)
        np.copyto(self._warped, target)
        cv2.remap(
            source, self._map_u, self._map_v, cv2.INTER_LINEAR, dst=self._warped, borderMode=cv2.BORDER_TRANSPARENT
        )

    def _linearize(self, target: Floats) -> None:
        np.add(self._warped, target, out=self._total)
        cv2.filter2D(self._total, -1, _ALONG_ROW, dst=self._gu)
        cv2.filter2D(self._total, -1, _ALONG_COLUMN, dst=self._gv)
        np.subtract(self._warped, target, out=self._difference)
        np.multiply(self._g, self._difference, out=self._gd)

    def _sum_windows(self, lines: slice, added: float = 0) -> None:
        cv2.sepFilter2D(
            self._products[lines],
            -1,
            self._kernel,
            self._kernel,
            dst=self._sums[lines],
            delta=added,
            borderType=cv2.BORDER_CONSTANT,
        )

    def _decompose(self) -> None:
        """Replace vv by vv - uv^2 / uu: the tensor's factors without a square root."""
        uu, vv, uv, _, _ = self._sum_planes
        cv2.divide(uv, uu, dst=self._ratio, scale=-1)
        cv2.accumulateProduct(uv, self._ratio, vv)

    def _correct(self) -> None:
        """Add the solution of [[uu, uv], [uv, vv]] d = (ud, vd) by elimination."""
        uu, vv, _, ud, vd = self._sum_planes
        u, v = self.planes
        cv2.accumulateProduct(ud, self._ratio, vd)
        np.divide(vd, vv, out=self._step)
        np.add(v, self._step, out=v)
        cv2.accumulateProduct(self._ratio, self._step, u)
        np.divide(ud, uu, out=self._step)
        np.add(u, self._step, out=u)
