"""Dominant plane as what a homography near the planar flow explains."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav import Flow, Planar, Plane, Stamp, param
from graphnav.arrays import Doubles
from graphnav_plane.detector import MIN_VECTORS, Detector, compared
from graphnav_plane.homography import cell_middles, drawn, moved

Indices = npt.NDArray[np.intp]
_SEED_RATIO = 2.0
"""Flow noise assumed of the seeds, in units of ``noise_px``."""
_PARALLAX_RATIO = 3.0
"""Difference from a plane that counts as above or below it, in units of ``noise_px``."""
_REPROJECTION_PX, _DRAWS = 0.1, 200
_STEPS = (1.5, 1.0, 1.0, 1.0)
"""Flow noise assumed at each step, in units of the actual: the first one narrows from the start's."""
_RIDGE = 1e-6
"""Of the fit, for each vector."""


class GuidedHomography(Detector):
    """Dominant plane by the planar flow plus a small homography.

    The planar flow says which plane is the floor, also where another one is larger; it errs where the camera rotates
    or odometry is wrong. A homography has neither fault, but takes the largest plane. Here the ground is the planar
    flow plus the flow of a homography near the identity (eight factors, to first order), fitted by reweighted least
    squares; the score is what that leaves of the flow.

    The vectors that agree with the planar flow seed the fit. Only if less than ``min_agreement_ratio`` of the vectors
    agree with its result, the vectors that agree with the free homography of `plane.homography` seed a second fit. It
    replaces the first if more vectors agree with it and if what does not is mostly nearer than its plane, as obstacles
    on a floor are: with respect to the top of an obstacle the floor flows backwards along the planar flow, and nothing
    is below a floor.

    On drives of the worlds of `graphnav ablate suite` that the true obstacle map steered (two seeds each, 40 s, planar
    flow of `planar.subspace`) AUROC was 0.991 among corners, 0.989 with low obstacles, 0.981 with a tilted camera and
    0.995 with a shaking one. `plane.residual` on the same planar flow had 0.991, 0.990, 0.983 and 0.783: the gain is
    under shake of the camera. `plane.homography` had 0.947, 0.983, 0.964 and 0.994.

    That cannot tell a floor that covers less than half of the view from an obstacle's top where the camera also
    rotates by so much that few vectors agree with the planar flow.
    """

    noise_px: float = param(
        0.1,
        gt=0.0,
        le=100_000.0,
        doc="flow noise: a vector that differs by this from the ground has a weight of a quarter",
    )
    min_agreement_ratio: float = param(
        0.6,
        ge=0.0,
        le=1.0,
        doc="mean agreement (1 for a vector on the ground, 1/2 at ``noise_px``) from which the fit seeded by the "
        "planar flow is taken without looking for a larger plane; 0 never looks for one",
    )

    def step(self, flow: Flow, planar: Planar, stamp: Stamp) -> Plane:
        """Return the plane on the grid of ``planar``; nothing is judged where fewer than 6 vectors are valid.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes or cover different times.
        """
        self._begin(stamp)
        cells, valid = compared(flow, planar)
        if np.count_nonzero(valid) < MIN_VECTORS:
            return self._unjudged(cells)
        judged = np.flatnonzero(valid)
        fields = small_homographies(*valid.shape)
        left_px = (cells.uv_px - planar.planar_uv_px).reshape(-1, 2).astype(np.float64)
        fit = self._fit(fields.take(judged, axis=1), left_px.take(judged, axis=0), cells, planar, judged)
        left_px -= np.einsum("i,ijk->jk", fit.factors, fields)
        return self._plane(self._remembered(left_px.reshape(cells.uv_px.shape), valid, cells), valid, cells.step_px)

    def _fit(self, fields: Doubles, vectors_px: Doubles, cells: Flow, planar: Planar, judged: Indices) -> Fit:
        """Return the fit to the floor; ``vectors_px``: (n, 2), flow minus planar flow of the ``judged`` cells."""
        seeds = agreement(vectors_px, _SEED_RATIO * self.noise_px)
        guided = fitted(fields, vectors_px, seeds, self.noise_px)
        if guided.agreement.mean() >= self.min_agreement_ratio:
            return guided
        seeds = agreement(_left_by_homography_px(cells, judged), _SEED_RATIO * self.noise_px)
        free = fitted(fields, vectors_px, seeds, self.noise_px)
        forward_px = planar.planar_uv_px.reshape(-1, 2).take(judged, axis=0).mean(axis=0)
        is_larger = free.agreement.sum() > guided.agreement.sum()
        return free if is_larger and self._is_lowest(free, forward_px.astype(np.float64)) else guided

    def _is_lowest(self, fit: Fit, forward_px: Doubles) -> bool:
        """Return whether what does not lie on the fitted plane is mostly above it: flows more along ``forward_px``."""
        along_px = fit.left_px @ forward_px
        limit = _PARALLAX_RATIO * self.noise_px * math.hypot(*forward_px.tolist())
        return bool(np.count_nonzero(along_px > limit) >= np.count_nonzero(along_px < -limit))


def _left_by_homography_px(cells: Flow, judged: Indices) -> Doubles:
    """Return what the homography with which most vectors agree leaves of each of the ``judged`` ones, (n, 2)."""
    places = cell_middles(*cells.valid.shape, cells.step_px).take(judged, axis=0)
    targets = places + cells.uv_px.reshape(-1, 2).take(judged, axis=0)
    return targets - moved(drawn(places, targets, "usac_magsac", _REPROJECTION_PX, _DRAWS), places)


class Fit(NamedTuple):
    """``factors``: (8,), of the fields. ``left_px``: (n, 2), what they leave. ``agreement``: (n,), from 1 down to 0."""

    factors: Doubles
    left_px: Doubles
    agreement: Doubles


@lru_cache(maxsize=16)
def small_homographies(rows: int, cols: int) -> Doubles:
    """Return the flows of the eight homographies near the identity, (8, rows * cols, 2).

    A rotation of the camera or a wrong scale adds them to the planar flow. To first order they are shifts, linear maps
    and the two quadratic fields of a plane's motion [HZ]; in units in which the longer side of the picture reaches from
    -1 to 1.

    References
    ----------
    .. [HZ] R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2004, section 8.1.
    """
    y, x = (np.mgrid[:rows, :cols].reshape(2, -1) - np.array([[rows - 1], [cols - 1]]) / 2) / (max(rows, cols) / 2)
    one, zero = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([one, zero, x, y, zero, zero, x * x, x * y])
    along_y = np.stack([zero, one, zero, zero, x, y, x * y, y * y])
    fields = np.stack([along_x, along_y], axis=-1)
    fields.setflags(write=False)
    return fields


def agreement(left_px: Doubles, noise_px: float) -> Doubles:
    """Return how far vectors agree with a fit that leaves ``left_px`` (n, 2) of them: 1/2 at ``noise_px``."""
    return np.asarray(1 / (1 + np.einsum("ij,ij->i", left_px, left_px) / noise_px**2))


def fitted(fields: Doubles, vectors_px: Doubles, start: Doubles, noise_px: float) -> Fit:
    """Fit ``fields`` (8, n, 2) to ``vectors_px`` (n, 2) by reweighted least squares (Geman and McClure's estimator).

    ``start``: (n,), how far each vector agrees with what the fit starts from, from 1 down to 0.
    """
    columns, values = fields.reshape(len(fields), -1), vectors_px.reshape(-1)
    factors = _solved(columns, values, start)
    for step in _STEPS:
        left_px = (values - factors @ columns).reshape(-1, 2)
        factors = _solved(columns, values, agreement(left_px, step * noise_px))
    left_px = (values - factors @ columns).reshape(-1, 2)
    return Fit(factors, left_px, agreement(left_px, noise_px))


def _solved(columns: Doubles, values: Doubles, agreed: Doubles) -> Doubles:
    """Return the factors (8,) by weighted least squares; a small ridge keeps them finite on a line of vectors."""
    weighted = columns * np.repeat(agreed * agreed, 2)
    ridge = _RIDGE * len(agreed) * np.eye(len(columns))
    return np.asarray(np.linalg.solve(weighted @ columns.T + ridge, weighted @ values))
