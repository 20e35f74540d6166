"""Dominant plane by independent component analysis of the flow and the planar flow."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import Components, Flow, Planar, Plane, Stamp, param
from graphnav.arrays import Bools, Doubles, Floats
from graphnav_plane.detector import MIN_VECTORS, Detector, compared
from graphnav_plane.separation import closed_form, iterated, robust_contrast
from graphnav_plane.separation.iterated import Nonlinearity
from graphnav_plane.separation.whitening import Whitened, whiten

Indices = npt.NDArray[np.intp]


class IcaOutputs(NamedTuple):
    """Outputs of `Ica`; ``components`` is left out where nothing reads it, and where nothing could be separated."""

    plane: Plane
    components: Components | None


class Separation(NamedTuple):
    """By what flow and planar flow add up to an obstacle's, px, and the component that it is: a row of ``unmixing``.

    ``unmixing``: (2, 2), None if nothing could be separated.
    """

    of_flow: float
    of_planar: float
    row: int
    unmixing: Doubles | None
    converged: bool


class Ica(Detector):
    """Dominant plane by separating two mixtures, the flow u and the planar flow û [OI, eq. 2, 3].

    Each mixture is one row: all horizontal parts, then all vertical ones. FastICA finds two independent components.
    One of them, v, is what an obstacle adds: a combination u - αû in which the ground cancels. The score is its
    length: ground where it is near 0.

    [OI] has the cubic nonlinearity, takes the mixtures about their means, and with m the median of ``|v|`` the score
    ``ε = | |v| - m |``. The first two are at fault where an obstacle is large: it decides the kurtosis and pulls the
    means. The third gives the stillest ground the score m, and splits it from the rest no better. So they are not the
    defaults; ``{component: low_variance, nonlinearity: cubic, centred: true, about: median, solver: sklearn,
    threshold_px: 0, edge_ratio: 0, memory_ratio: 0}`` is [OI] as printed.

    FastICA gives components of unit variance, in which noise looks as large as a wall. So the score is in pixels: the
    component is divided by its greater unmixing coefficient, which makes it u - αû itself. Only so can a threshold
    tell an obstacle from the noise that is all that the component holds on an empty floor.

    ``components`` publishes both components, their mixing and their variances.

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
        self._publishes_components = self.is_read("components")
        self._unmixing: Doubles = np.random.default_rng(seed).standard_normal((2, 2))

    def step(self, flow: Flow, planar: Planar, stamp: Stamp) -> IcaOutputs:
        """Return the plane on the grid of ``planar``; nothing is judged where fewer than 6 vectors are valid.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes or cover different times.
        """
        self._begin(stamp)
        cells, valid = compared(flow, planar)
        if np.count_nonzero(valid) < MIN_VECTORS:
            return IcaOutputs(self._unjudged(cells), None)
        judged = np.flatnonzero(valid)
        found = self._separated(_mixtures(cells.uv_px, planar.planar_uv_px, judged))
        left_px = cv2.addWeighted(cells.uv_px, found.of_flow, planar.planar_uv_px, found.of_planar, 0.0)
        score = self._remembered(left_px, valid, cells)
        if self.about == "median":
            score = np.where(valid, np.abs(score - np.median(score[valid])), np.float32(0.0))
        plane = self._plane(score, valid, cells.step_px, converged=found.converged)
        if found.unmixing is None or not self._publishes_components:
            return IcaOutputs(plane, None)
        return IcaOutputs(plane, components(cells, planar, valid, found.unmixing, found.row))

    def _separated(self, mixtures: Doubles) -> Separation:
        white = whiten(mixtures, self.min_eigenvalue_ratio, centred=self.centred)
        if white is None:
            return Separation(1.0, -_gain(mixtures), 0, None, converged=True)
        rotation, converged = self._rotation(white)
        self._unmixing = rotation @ white.matrix
        row = self._which(rotation @ white.samples, mixtures)
        of_flow, of_planar = self._unmixing[row].tolist()
        scale = math.copysign(max(abs(of_flow), abs(of_planar)), of_flow)
        return Separation(of_flow / scale, of_planar / scale, row, self._unmixing, converged)

    def _rotation(self, white: Whitened) -> tuple[Doubles, bool]:
        if self.solver == "sklearn":
            start = self._unmixing @ np.linalg.inv(white.matrix)
            return iterated.rotation(white.samples, start, self.nonlinearity)
        direct = closed_form if self.nonlinearity == "cubic" else robust_contrast
        return direct.rotation(white.samples), True

    def _which(self, centred: Doubles, mixtures: Doubles) -> int:
        """Return the index of the obstacle's component of two; ``centred``: both as they were separated, (2, 2n)."""
        if self.component == "kurtosis":
            squares = centred * centred
            return int(np.argmax(np.einsum("ij,ij->i", squares, squares)))
        components = self._unmixing @ mixtures
        spread = np.hypot(*components.reshape(2, 2, -1).transpose(1, 0, 2)).var(axis=1)
        return int(np.argmax(spread) if self.component == "high_variance" else np.argmin(spread))


def _mixtures(flow_px: Floats, planar_px: Floats, judged: Indices) -> Doubles:
    """Return the vectors (rows, cols, 2) of the judged cells, (2, 2n): all horizontal parts, then all vertical ones."""
    return np.array([field.reshape(-1, 2).T.take(judged, axis=1).reshape(-1) for field in (flow_px, planar_px)], float)


def _gain(mixtures: Doubles) -> float:
    """Return the multiple of the planar flow that is nearest to the flow."""
    flow, planar = mixtures
    square = float(planar @ planar)
    return float(flow @ planar) / square if square else 0.0


def components(cells: Flow, planar: Planar, valid: Bools, unmixing: Doubles, taken: int) -> Components:
    """Return what ``unmixing`` (2, 2) makes of flow and planar flow, in the order of the variance of their lengths.

    ``taken``: the row of ``unmixing`` that the score is made from. Means are not removed, so that the mixing of the
    components is the flow itself [OI, eq. 2].
    """
    mixtures = np.stack([cells.uv_px, planar.planar_uv_px]).astype(np.float64)
    fields = np.einsum("ij,jrck->irck", unmixing, mixtures) * valid[:, :, None]
    variances = np.linalg.norm(fields[:, valid], axis=-1).var(axis=1)
    order = np.argsort(variances, kind="stable")
    alpha, beta = fields[order].astype(np.float32)
    return Components(
        alpha=alpha,
        beta=beta,
        mixing=np.asarray(np.linalg.inv(unmixing)[:, order], np.float64),
        variances=variances[order],
        taken=int(np.flatnonzero(order == taken)[0]),
        valid=valid.astype(np.uint8),
        step_px=cells.step_px,
    )
