"""A Lucas-Kanade iteration on one pyramid layer: warp, linearize, solve for a correction."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Floats

# Derivative of the five-point polynomial; halved, because it is applied to the sum of two images.
_ALONG_ROW = np.array([[1, -8, 0, 8, -1]], np.float32) / np.float32(24)
_ALONG_COLUMN = _ALONG_ROW.T.copy()

_ZERO = np.float32(0)
"""Added to copy an image: memcpy is ten times slower on some processors if the addresses agree modulo 4096."""


class Refinement:
    """Improves a displacement field between two images of one size; reuses its buffers.

    With f0 the smoothed field so far, J the source image, I the target image, Jw(x) = J(x - f0(x)) and g the mean
    gradient of I and Jw, it solves in a window around each pixel for the correction d::

        (sum g g' + e) d = sum g (Jw - I)        f = f0 + d

    Without smoothing first, every correction adds noise that later ones do not remove. Smoothing f0 instead of d makes
    a linearly varying field, as that of a plane nearly is, a fixed point; a larger window would bias it toward texture.
    Where x - f0 leaves the source image, Jw - I is 0: the field is continued.

    ``field``: float32 (2, rows, cols), u and v, also as ``planes``; the caller writes f0 and reads f there. Arguments
    are positional, because parsing keywords takes as long as the work on a small layer.

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
        # The planes of a field lie below each other in one image: half the calls.
        self._field_lines, self._map = np.zeros((2, 2 * rows, cols), np.float32)
        self.field = self._field_lines.reshape(2, rows, cols)
        self.planes = tuple(self.field)
        self._map_u, self._map_v = self._map[:rows], self._map[rows:]
        self._step = self._map.reshape(2, rows, cols)  # used when the map no longer is
        self._warped, self._total, self._ratio = np.empty((3, rows, cols), np.float32)
        self._g = np.empty((2, rows, cols), np.float32)
        self._gu, self._gv = self._g
        self._kernel = np.full((1, window_px), 1 / window_px, np.float32)
        # So do the products, apart by half a window of zeros: one filter sums several.
        pitch = rows + window_px // 2
        products, sums = np.zeros((3 * pitch, cols), np.float32), np.zeros((5 * pitch, cols), np.float32)
        planes = products.reshape(3, pitch, cols)[:, :rows]
        self._squares, self._uv, self._gd = planes[:2], planes[0], planes[1:]
        self._diagonal = products[: 2 * pitch], sums[: 2 * pitch]
        self._others = products, sums[2 * pitch :]
        self._right_side = products[pitch:], sums[3 * pitch :]
        summed = sums.reshape(5, pitch, cols)[:, :rows]
        self._uu_vv, self._ud_vd = summed[:2], summed[3:]
        self._sums = tuple(summed)

    def improve(self, target: Floats, source: Floats, *, keep_tensor: bool = False) -> None:
        """Add the correction to the field: target pixel x is found at x - (u, v) in the source.

        ``keep_tensor``: take the structure tensor sum g g' of the last call.
        """
        self._warp(target, source)
        self._linearize(target)
        if not keep_tensor:
            np.multiply(self._g, self._g, self._squares)
            self._sum_windows(*self._diagonal, self._regularization_gray2)
            np.multiply(self._gu, self._gv, self._uv)
        np.multiply(self._g, self._warped, self._gd)
        self._sum_windows(*(self._right_side if keep_tensor else self._others))
        if not keep_tensor:
            self._decompose()
        self._correct()

    def statistics(self, every: int) -> tuple[Floats, Floats, Floats]:
        """Return what the last correction leaves, at one pixel in ``every`` each way, three float32 (rows, cols).

        The mean squared difference between both images in the window, and half the sum and half the difference of the
        structure tensor's eigenvalues without the regularization. Only until the next call of `improve`.
        """
        at = np.s_[::every, ::every]
        np.multiply(self._warped, self._warped, self._total)
        cv2.sepFilter2D(self._total, -1, self._kernel, self._kernel, self._total, (-1, -1), 0.0, cv2.BORDER_CONSTANT)
        uu, vv, uv, ud, vd = (one[at].copy() for one in self._sums)
        du, dv = self._step[:, *at].copy()
        left: Floats = self._total[at] - ud * du - vd * dv
        # Undo `_decompose`.
        vv = vv - uv * self._ratio[at]
        half: Floats = (uu + vv) / 2 - np.float32(self._regularization_gray2)
        apart: Floats = np.hypot((uu - vv) / 2, uv)
        return left, half, apart

    def _warp(self, target: Floats, source: Floats) -> None:
        cv2.addWeighted(self._field_lines, -self._zoom, self._places, 1.0, 0.0, self._map)
        np.add(target, _ZERO, self._warped)
        cv2.remap(source, self._map_u, self._map_v, cv2.INTER_LINEAR, self._warped, cv2.BORDER_TRANSPARENT)

    def _linearize(self, target: Floats) -> None:
        """Write the mean gradient; from here on ``_warped`` holds Jw - I."""
        np.add(self._warped, target, self._total)
        cv2.filter2D(self._total, -1, _ALONG_ROW, self._gu)
        cv2.filter2D(self._total, -1, _ALONG_COLUMN, self._gv)
        np.subtract(self._warped, target, self._warped)

    def _sum_windows(self, products: Floats, sums: Floats, added: float = 0.0) -> None:
        cv2.sepFilter2D(products, -1, self._kernel, self._kernel, sums, (-1, -1), added, cv2.BORDER_CONSTANT)

    def _decompose(self) -> None:
        """Replace vv by vv - uv^2 / uu, for the elimination of du."""
        uu, vv, uv, _, _ = self._sums
        cv2.divide(uv, uu, self._ratio, -1.0)
        cv2.accumulateProduct(uv, self._ratio, vv)

    def _correct(self) -> None:
        """Add the solution of [[uu, uv], [uv, vv]] d = (ud, vd) to the field."""
        _, _, _, ud, vd = self._sums
        cv2.accumulateProduct(ud, self._ratio, vd)
        np.divide(self._ud_vd, self._uu_vv, self._step)
        np.add(self.field, self._step, self.field)
        cv2.accumulateProduct(self._ratio, self._step[1], self.field[0])
