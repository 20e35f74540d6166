"""Motion and depth of the pixels of a plane: homography and nearness."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles

MIN_PIXELS = 4
"""Number of pixels that determine a homography."""


def homography(points: Doubles, before: Doubles) -> Doubles | None:
    """Return the homography (3, 3), float64, that takes ``points`` to ``before``, both (n, 2).

    Linear least squares with the last element 1 [HZ, section 4.1]: exact for exact points, and as accurate as the
    points if they are near the origin and of size about one. None if they do not determine it: fewer than four, or
    (nearly) on a line.

    References
    ----------
    .. [HZ] R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2nd edition, 2004.
    """
    if len(points) < MIN_PIXELS:
        return None
    x, y = points.T
    one, none = np.ones_like(x), np.zeros_like(x)
    u, v = before.T
    rows_u = np.stack([x, y, one, none, none, none, -u * x, -u * y], axis=1)
    rows_v = np.stack([none, none, none, x, y, one, -v * x, -v * y], axis=1)
    found, _, rank, _ = np.linalg.lstsq(np.concatenate([rows_u, rows_v]), np.concatenate([u, v]), rcond=1e-9)
    if rank < found.size:
        return None
    return np.append(found, 1.0).reshape(3, 3)


def moved(matrix: Doubles, points: Doubles) -> tuple[Doubles, Doubles]:
    """Return the images of points (..., 2) under a homography, and their divisors (...).

    A divisor that is not positive means that the point of the plane lies behind the other camera.
    """
    places = points @ matrix[:, :2].T + matrix[:, 2]
    scale = places[..., 2]
    return places[..., :2] / np.where(scale == 0.0, np.inf, scale)[..., None], scale


def nearness(seen: Doubles, depth_m: npt.NDArray[np.floating], points: Doubles) -> Doubles:
    """Return one over the depth of the plane at ``points`` (..., 2), from its depth (n,) at the points ``seen`` (n, 2).

    It changes linearly over the picture; above the plane's horizon it is negative.
    """
    terms = np.column_stack([seen, np.ones(len(seen))])
    slope_x, slope_y, there = np.linalg.lstsq(terms, 1 / depth_m.astype(np.float64), rcond=None)[0]
    return np.asarray(points @ np.array([slope_x, slope_y]) + there)
