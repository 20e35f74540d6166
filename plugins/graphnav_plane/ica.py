"""Dominant plane by independent component analysis of the flow and the planar flow."""

from __future__ import annotations

from typing import Literal

import numpy as np

from graphnav import Flow, Planar, Plane, Stamp, param
from graphnav.arrays import Doubles
from graphnav_plane.detector import MIN_VECTORS, Detector, compared
from graphnav_plane.separation import closed_form, iterated, robust_contrast
from graphnav_plane.separation.iterated import Nonlinearity
from graphnav_plane.separation.whitening import Whitened, whiten


class Ica(Detector):
    """Dominant plane by separating two mixtures, the flow u and the planar flow û [OI, eq. 2, 3].

    Each mixture is one row: all horizontal parts, then all vertical ones. FastICA finds two independent components.
    One of them, v, is what an obstacle adds: a combination u - αû in which the ground cancels. The score is its
    length: ground where it is near 0.

    [OI] has the cubic nonlinearity, takes the mixtures about their means, and with m the median of ``|v|`` the score
    ``ε = | |v| - m |``. The first two are at fault where an obstacle is large: it decides the kurtosis and pulls the
    means. The third gives the stillest ground the score m, and splits it from the rest no better. So they are not the
    defaults; ``{nonlinearity: cubic, centred: true, about: median, edge_ratio: 0, memory_ratio: 0}`` is [OI]'s own.

    FastICA gives components of unit variance, in which noise looks as large as a wall. So the score is in pixels: the
    component is divided by its greater unmixing coefficient, which makes it u - αû itself. Only so can a threshold
    tell an obstacle from the noise that is all that the component holds on an empty floor.

    If one mixture adds nothing to the other (at rest û = 0, on a floor without noise u is a multiple of it)
    nothing can be separated: α is what fits best.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 3.
    """

    component: Literal["kurtosis", "high_variance", "low_variance"] = param(
        "kurtosis",
        doc="selection of the obstacle's component: the one of higher kurtosis (few large values among many small "
        "ones), or, as [OI] orders them, of high or low variance of its length",
    )
    nonlinearity: Nonlinearity = param(
        "gauss",
        doc="of FastICA: gauss is reliable for sparse components; cubic, as in [OI], is dominated by the largest "
        "samples",
    )
    centred: bool = param(
        False,
        doc="centre the mixtures at their means, as in [OI]; false: at zero, where the ground alone would be",
    )
    about: Literal["zero", "median"] = param(
        "zero", doc="reference from which |v| of an obstacle deviates; median: as in [OI]"
    )
    solver: Literal["direct", "sklearn"] = param(
        "direct",
        doc="direct: the maximum contrast, without a start; sklearn: iteration, started from the last frame",
    )
    min_eigenvalue_ratio: float = param(
        1e-9,
        ge=0.0,
        lt=1.0,
        doc="smaller divided by larger eigenvalue of the mixtures' covariance up to which they count as one",
        renamed_from="least_eigenvalue_ratio",
    )

    def reset(self, seed: int) -> None:
        """Draw the start of the iteration in the first frame; forget the last frames."""
        super().reset(seed)
        self._unmixing: Doubles = np.random.default_rng(seed).standard_normal((2, 2))

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
        fields = np.stack([cells.uv_px[valid], planar.planar_uv_px[valid]]).astype(np.float64)
        mixtures = fields.transpose(0, 2, 1).reshape(2, -1)
        left_px, converged = self._separated(mixtures)
        score = self._remembered(left_px.reshape(2, -1).T, valid, cells)
        if self.about == "median":
            score = np.abs(score - np.median(score[valid]))
        return self._plane(score, valid, cells.step_px, converged=converged)

    def _separated(self, mixtures: Doubles) -> tuple[Doubles, bool]:
        """Return the contribution of obstacles to the flow, px, (2n,), and whether the iteration converged."""
        white = whiten(mixtures, self.min_eigenvalue_ratio, centred=self.centred)
        if white is None:
            return _fitted(mixtures), True
        rotation, converged = self._rotation(white)
        self._unmixing = rotation @ white.matrix
        of_flow, of_planar = self._unmixing[self._which(rotation @ white.samples, self._unmixing @ mixtures)]
        scale = np.copysign(max(abs(of_flow), abs(of_planar)), of_flow)
        return np.asarray((of_flow / scale) * mixtures[0] + (of_planar / scale) * mixtures[1]), converged

    def _rotation(self, white: Whitened) -> tuple[Doubles, bool]:
        if self.solver == "sklearn":
            start = self._unmixing @ np.linalg.inv(white.matrix)
            return iterated.rotation(white.samples, start, self.nonlinearity)
        direct = closed_form if self.nonlinearity == "cubic" else robust_contrast
        return direct.rotation(white.samples), True

    def _which(self, centred: Doubles, components: Doubles) -> int:
        """Return the index of the obstacle's component of two, (2, 2n); ``centred``: as they were separated."""
        if self.component == "kurtosis":
            squares = centred * centred
            return int(np.argmax((squares * squares).sum(axis=1)))
        spread = np.hypot(*components.reshape(2, 2, -1).transpose(1, 0, 2)).var(axis=1)
        return int(np.argmax(spread) if self.component == "high_variance" else np.argmin(spread))


def _fitted(mixtures: Doubles) -> Doubles:
    """Return the residual of the flow after subtracting the best multiple of the planar flow, (2n,)."""
    flow, planar = mixtures
    square = planar @ planar
    gain = float(flow @ planar / square) if square else 0.0
    return np.asarray(flow - gain * planar)
