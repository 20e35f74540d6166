"""Dominant plane by independent component analysis of the flow and the planar flow."""

from __future__ import annotations

from typing import Literal

import numpy as np

from graphnav import Flow, Planar, Plane, param
from graphnav_plane import closed_form, iterated
from graphnav_plane.detector import LEAST_VECTORS, Detector, all_ground, compared
from graphnav_plane.whitening import Doubles, Whitened, whiten


class Ica(Detector):
    """Dominant plane by separating two mixtures, the flow u and the planar flow û [OI, eq. 2, 3].

    Each mixture is one row: all horizontal parts, then all vertical ones. FastICA (by deflation, cubic nonlinearity,
    means restored) finds two independent components. One of them, v, is what an obstacle adds: a combination u - αû
    in which the ground cancels. With m the median of ``|v|``, the score is ``ε = | |v| - m |``; ground where it is
    near 0.

    FastICA gives components of unit variance, in which noise looks as large as a wall. So ε is in pixels: the
    component is divided by its greater unmixing coefficient, which makes it u - αû itself. Only so can a threshold
    tell an obstacle from the noise that is all that the component holds on an empty floor.

    Where one mixture says nothing beside the other (at rest, û = 0) nothing can be separated: all ground.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 3.
    """

    component: Literal["kurtosis", "high_variance", "low_variance"] = param(
        "kurtosis",
        doc="which component is the obstacle's: the one of higher kurtosis (few large values among many small ones), "
        "or, as [OI] orders them, of high or low variance of its length",
    )
    solver: Literal["closed_form", "sklearn"] = param(
        "closed_form", doc="closed_form: exact, without a start; sklearn: its iteration, started from the last frame"
    )
    least_eigenvalue_ratio: float = param(
        1e-9,
        ge=0.0,
        lt=1.0,
        doc="lesser by greater eigenvalue of the mixtures' covariance up to which they count as one: all ground",
    )

    def reset(self, seed: int) -> None:
        """Draw where the iteration starts in the first frame."""
        self._unmixing: Doubles = np.random.default_rng(seed).standard_normal((2, 2))

    def step(self, flow: Flow, planar: Planar) -> Plane:
        """Return the plane on the grid of ``planar``; nothing is judged where fewer than 6 vectors are valid.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes.
        """
        cells, valid = compared(flow, planar)
        if np.count_nonzero(valid) < LEAST_VECTORS:
            return all_ground(valid.shape, cells.step_px)
        fields = np.stack([cells.uv_px[valid], planar.planar_uv_px[valid]]).astype(np.float64)
        mixtures = fields.transpose(0, 2, 1).reshape(2, -1)
        score = np.zeros(valid.shape)
        white = whiten(mixtures, self.least_eigenvalue_ratio)
        if white is None:
            return self._plane(score, valid, cells.step_px)
        rotation, converged = self._rotation(white)
        self._unmixing = rotation @ white.matrix
        components = self._unmixing @ mixtures
        lengths = np.hypot(*components.reshape(2, 2, -1).transpose(1, 0, 2))
        which = self._which(rotation @ white.samples, lengths)
        v_px = lengths[which] / np.abs(self._unmixing[which]).max()
        score[valid] = np.abs(v_px - np.median(v_px))
        return self._plane(score, valid, cells.step_px, converged=converged)

    def _rotation(self, white: Whitened) -> tuple[Doubles, bool]:
        if self.solver == "closed_form":
            return closed_form.rotation(white.samples), True
        return iterated.rotation(white.samples, self._unmixing @ np.linalg.inv(white.matrix))

    def _which(self, components: Doubles, lengths: Doubles) -> int:
        """Return the place of the obstacle's component; ``components`` (2, 2n) are centred, of unit variance."""
        if self.component == "kurtosis":
            squares = components * components
            return int(np.argmax((squares * squares).sum(axis=1)))
        spread = lengths.var(axis=1)
        return int(np.argmax(spread) if self.component == "high_variance" else np.argmin(spread))
