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

    Neighbouring windows share most of their pixels. With ``every`` = 2 the system is solved at every second pixel each
    way: the products are averaged and thinned out first, and the window then is as wide as before.

    ``field``: float32 (2, rows, cols), u and v, also as ``planes``; the caller writes f0 there. ``solved``: f, at one
    pixel in ``every`` each way, two planes; with ``every`` = 1 those of ``field``. Arguments are positional, because
    parsing keywords takes as long as the work on a small layer.

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
    every
        1 or 2.
    """

    def __init__(
        self, rows: int, cols: int, *, window_px: int, regularization_gray2: float, zoom: int = 1, every: int = 1
    ) -> None:
        self._regularization_gray2, self._zoom, self._every = regularization_gray2, zoom, every
        down, right = np.mgrid[:rows, :cols].astype(np.float32)
        self._places = zoom * np.concatenate([right, down])
        # The planes of a field lie below each other in one image: half the calls.
        self._field_lines, self._map = np.zeros((2, 2 * rows, cols), np.float32)
        self.field = self._field_lines.reshape(2, rows, cols)
        self.planes = tuple(self.field)
        self._map_u, self._map_v = self._map[:rows], self._map[rows:]
        self._warped, self._total = np.empty((2, rows, cols), np.float32)
        self._g = np.empty((2, rows, cols), np.float32)
        self._gu, self._gv = self._g
        self._kernel = np.full((1, window_px), 1 / window_px, np.float32) if every == 1 else thinned(window_px)
        few_rows, few_cols = (-(-side // every) for side in (rows, cols))
        self._start, self._step = self.field[:, ::every, ::every], np.empty((2, few_rows, few_cols), np.float32)
        self.solved = self.planes if every == 1 else tuple(np.empty((2, few_rows, few_cols), np.float32))
        self._ratio = np.empty((few_rows, few_cols), np.float32)
        # So do the products, apart by half a window of zeros: one filter sums several.
        few_pitch = few_rows + self._kernel.size // 2 + every - 1
        products = np.zeros((3 * every * few_pitch, cols), np.float32)
        few = products if every == 1 else np.empty((3 * few_pitch, few_cols), np.float32)
        sums = np.zeros((5 * few_pitch, few_cols), np.float32)
        planes = products.reshape(3, every * few_pitch, cols)[:, :rows]
        self._squares, self._uv, self._gd = planes[:2], planes[0], planes[1:]

        def part(first: int, end: int, first_sum: int) -> tuple[Floats, Floats, Floats]:
            pitch = every * few_pitch
            return (
                products[first * pitch : end * pitch],
                few[first * few_pitch : end * few_pitch],
                sums[first_sum * few_pitch :][: (end - first) * few_pitch],
            )

        self._diagonal, self._others, self._right_side = part(0, 2, 0), part(0, 3, 2), part(1, 3, 3)
        summed = sums.reshape(5, few_pitch, few_cols)[:, :few_rows]
        self._uu_vv, self._ud_vd = summed[:2], summed[3:]
        self._sums = tuple(summed)

    def improve(self, target: Floats, source: Floats, *, keep_tensor: bool = False) -> None:
        """Add the correction to the field: target pixel x is found at x - (u, v) in the source.

        ``keep_tensor``: take the structure tensor sum g g' of the last call.
        """
        self._warp(target, source, self._warped)
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

        ``every``: a multiple of that of the solution.

        The mean squared difference between both images in the window, and half the sum and half the difference of the
        structure tensor's eigenvalues without the regularization. Only until the next call of `improve`.
        """
        at = np.s_[:: every // self._every, :: every // self._every]
        np.multiply(self._warped, self._warped, self._total)
        squared = self._total if self._every == 1 else cv2.pyrDown(self._total)
        cv2.sepFilter2D(squared, -1, self._kernel, self._kernel, squared, (-1, -1), 0.0, cv2.BORDER_CONSTANT)
        uu, vv, uv, ud, vd = (one[at].copy() for one in self._sums)
        du, dv = self._step[:, *at].copy()
        left: Floats = squared[at] - ud * du - vd * dv
        # Undo `_decompose`.
        vv = vv - uv * self._ratio[at]
        half: Floats = (uu + vv) / 2 - np.float32(self._regularization_gray2)
        apart: Floats = np.hypot((uu - vv) / 2, uv)
        return left, half, apart

    def warped(self, target: Floats, source: Floats) -> Floats:
        """Return the source image by the field, the target where it leaves it, (rows, cols); until the next call."""
        self._warp(target, source, self._total)
        return self._total

    def _warp(self, target: Floats, source: Floats, warped: Floats) -> None:
        cv2.addWeighted(self._field_lines, -self._zoom, self._places, 1.0, 0.0, self._map)
        np.add(target, _ZERO, warped)
        cv2.remap(source, self._map_u, self._map_v, cv2.INTER_LINEAR, warped, cv2.BORDER_TRANSPARENT)

    def _linearize(self, target: Floats) -> None:
        """Write the mean gradient; from here on ``_warped`` holds Jw - I."""
        np.add(self._warped, target, self._total)
        cv2.filter2D(self._total, -1, _ALONG_ROW, self._gu)
        cv2.filter2D(self._total, -1, _ALONG_COLUMN, self._gv)
        np.subtract(self._warped, target, self._warped)

    def _sum_windows(self, products: Floats, few: Floats, sums: Floats, added: float = 0.0) -> None:
        if self._every > 1:
            cv2.pyrDown(products, few)
        cv2.sepFilter2D(few, -1, self._kernel, self._kernel, sums, (-1, -1), added, cv2.BORDER_CONSTANT)

    def _decompose(self) -> None:
        """Replace vv by vv - uv^2 / uu, for the elimination of du."""
        uu, vv, uv, _, _ = self._sums
        cv2.divide(uv, uu, self._ratio, -1.0)
        cv2.accumulateProduct(uv, self._ratio, vv)

    def _correct(self) -> None:
        """Write f, with the solution of [[uu, uv], [uv, vv]] d = (ud, vd)."""
        _, _, _, ud, vd = self._sums
        cv2.accumulateProduct(ud, self._ratio, vd)
        np.divide(self._ud_vd, self._uu_vv, self._step)
        u, v = self.solved
        np.add(self._start[0], self._step[0], u)
        np.add(self._start[1], self._step[1], v)
        cv2.accumulateProduct(self._ratio, self._step[1], u)


def thinned(window_px: int) -> Floats:
    """Return a box for every second pixel, (1, side): with pyrDown before it or pyrUp after as wide as a window."""
    return box(max((window_px**2 - 9) / 4, 1.0) ** 0.5)


def box(width: float) -> Floats:
    """Return a box of any width as a kernel of sum 1, (1, side), whose outer elements count in part."""
    inner = 2 * int((width - 1) / 2) + 1
    rest = (width - inner) / 2
    kernel: Floats = (np.array([[rest, *[1] * inner, rest]]) / width).astype(np.float32)
    return kernel
