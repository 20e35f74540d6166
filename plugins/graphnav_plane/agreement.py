"""Which vectors agree with a fit: the rule by which robust fits choose what to fit to next."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Bools, Doubles

_SIGMA_OF_MEDIAN = 1.4826
_INLIER_SIGMAS = 2.5


def agrees(left_px: Doubles, noise_px: float) -> Bools:
    """Return where a fit leaves at most as much as `inlier_limit_px` of ``left_px``, (n,)."""
    return left_px <= inlier_limit_px(left_px, noise_px)


def inlier_limit_px(left_px: Doubles, noise_px: float) -> float:
    """Return 2.5 standard deviations of what a fit leaves, below which a vector agrees with it.

    ``left_px``: (n,), lengths of what the fit leaves. Their standard deviation is taken from their median, as if all
    were normal noise, so that up to half of them may be anything [Rousseeuw, Leroy: Robust Regression and Outlier
    Detection, 1987]. What is left by ``noise_px`` or less always agrees.
    """
    sigma = max(_SIGMA_OF_MEDIAN * float(median(left_px)), noise_px / _INLIER_SIGMAS)
    return _INLIER_SIGMAS * sigma


def median(values: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """Return the upper median along the last axis, several times as fast as numpy's."""
    middle = values.shape[-1] // 2
    return np.partition(values, middle, axis=-1)[..., middle]


def length(vectors: Doubles) -> Doubles:
    """Return the lengths of ``vectors`` (n, 2), (n,)."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))
