"""Predicted deviation of flow vectors: how far each is likely to be off, from the two pictures alone."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from graphnav.arrays import Floats
from graphnav_flow.pyramid import Pyramid
from graphnav_flow.refinement import Refinement
from graphnav_flow.repetition import Repetition

STEP_PX = 4
"""Side of the blocks of the prediction: windows of 9 and 11 px leave little that is finer."""
COARSE_LAYER = 2
_NOISE_GRADIENT = 0.26
"""Variance of the mean gradient of two images that show only noise, in units of the squared difference between
them: 0.23 by the derivative's kernel, and what a window of 81 pixels adds by chance."""
_INDEPENDENT_RATIO = 3.0
"""Pixels that count as independent, per pixel of a window: the vectors of a box of windows are averaged."""
_COARSE_WEIGHT = 0.05
"""By which the information of the coarse layer counts: what the base has none of is taken from above it, once."""
_ROUGH_WEIGHT = 0.45
_MIN_PX2, _MAX_PX2 = 2e-4, 9.0
_MIN_GRAY2 = 1e-2


class Deviation:
    """Predicts the root mean square length of the error of each vector; reuses its buffers.

    In a window, least squares for a displacement with noise of variance s^2 has the covariance s^2 (sum g g')^-1
    [SAH]. Here s^2 is half the squared difference that the solution leaves between both images: it holds the noise of
    the camera, and whatever else does not match, as where the picture is new in every frame. Noise has gradients, too:
    what noise of s^2 would have is taken from the eigenvalues of the structure tensor. Where they then are near 0 at
    the base, the vector comes from the layers above, and counts with what the second one knows.

    Vectors are averaged over a box, and so are their variances: errors within it are alike. To them the squared
    difference between a vector before and after that average is added, which is large at the edges of obstacles and
    where neighbouring windows find different displacements.

    Where the picture repeats, so that a displacement by one period explains it as well, and the displacement is not
    small against that period, the period is added (`Repetition`).

    References
    ----------
    .. [SAH] E. P. Simoncelli, E. H. Adelson, D. J. Heeger, Probability Distributions of Optical Flow, CVPR 1991.
    """

    def __init__(self, rows: int, cols: int, window_px: int, smooth_px: int) -> None:
        self._of_pixel = np.float32(1 / (_INDEPENDENT_RATIO * window_px**2))
        self._size = (-(-cols // STEP_PX), -(-rows // STEP_PX))
        side = 2 * (smooth_px // (2 * STEP_PX)) + 1
        self._box = (side, side)
        self._repetition = Repetition()

    def predict_px(self, solved: Sequence[Refinement], pyramid: Pyramid, rough: Floats, smooth: Floats) -> Floats:
        """Return the deviation on blocks of ``STEP_PX``, float32 (rows, cols), px.

        ``solved``: that of each layer of ``pyramid``, the base first, after the last iteration. ``rough``: the
        flow before its average, at every second pixel, ``smooth``: after it, (rows, cols, 2).
        """
        smaller, larger = _information(solved[0], STEP_PX)
        if len(solved) > COARSE_LAYER:
            above, _ = _information(solved[COARSE_LAYER], 1)
            above *= np.float32(_COARSE_WEIGHT / 4**COARSE_LAYER)
            known = cv2.resize(above, self._size)
            smaller += known
            larger += known
        floor = self._of_pixel / np.float32(_MAX_PX2)
        variance = self._of_pixel / np.maximum(smaller, floor) + self._of_pixel / np.maximum(larger, floor)
        blocks = np.s_[::STEP_PX, ::STEP_PX]
        off = (rough[:: STEP_PX // 2, :: STEP_PX // 2] - smooth[blocks]).view(np.complex64)[..., 0]
        variance += np.float32(_ROUGH_WEIGHT) * np.square(np.abs(off))
        mean = cv2.blur(variance, self._box)
        mean += np.float32(_MIN_PX2)
        ambiguous_px2 = self._repetition.ambiguous_px2(pyramid.layers, smooth[blocks])
        if ambiguous_px2 is not None:
            mean += ambiguous_px2
        deviation: Floats = np.sqrt(mean, mean)
        return deviation


def _information(refinement: Refinement, every: int) -> tuple[Floats, Floats]:
    """Return the smaller and larger eigenvalue of what a pixel tells, 1/px^2, at one pixel in so many each way."""
    left, half, apart = refinement.statistics(every)
    np.maximum(left, np.float32(_MIN_GRAY2), out=left)
    half -= np.float32(_NOISE_GRADIENT) * left
    return np.maximum(half - apart, 0) / left, np.maximum(half + apart, 0) / left
