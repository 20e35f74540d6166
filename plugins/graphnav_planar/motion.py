"""Planar flow for the motion of the frame, from odometry."""

from __future__ import annotations

import numpy as np

import graphnav
from graphnav import Flow, ParamError, Planar, PlanarModel, coarsen, param
from graphnav.arrays import Doubles, Floats
from graphnav_planar.estimation.egomotion import FREE_NOISE_FACTORS
from graphnav_planar.estimation.robust import NOISE_PX, weights
from graphnav_planar.estimation.series import Series
from graphnav_planar.interval import IntervalCheck
from graphnav_planar.taught import Taught, check_size, planar, vectors
from graphnav_planar.terms import driving_terms, free_terms, orders

_ITERATIONS = 3
_RIDGE = 1e-6 / NOISE_PX**2
"""In units of the squared flow noise."""


class Motion(Taught):
    """Planar flow for the current motion, from the basis that `planar.teach` fitted.

    Extends [OI, eq. 1], whose mean holds for one constant motion, to a robot that turns. Outside the taught
    motions the basis is inaccurate, and the error looks like an obstacle: teach more than the controller may command.

    An odometry error of two per cent shifts the planar flow by a tenth of a pixel in a turn, as much as a low obstacle
    does. So the motion is corrected, within ``odometry_error_ratio``, to agree with most of the flow.

    Odometry does not know how a camera pitches, rolls and bounces. A model with principal components (``components`` of
    `planar.teach`) has their flow: their factors are free, and fitted together with the correction. A model of
    components alone, taught without odometry, is for `planar.subspace`.

    A live flow that could not follow every image covers several motions, and only the last is at hand: nothing is
    published for it.
    """

    odometry_error_ratio: float = param(
        0.1,
        ge=0.0,
        lt=1.0,
        doc="maximum relative correction of the motion to fit the flow: the error of odometry, when teaching and now; "
        "0 does not correct it",
    )

    def reset(self, seed: int) -> None:
        """Read the model."""
        super().reset(seed)
        self._intervals = IntervalCheck()

    def step(self, flow: Flow, motion: graphnav.Motion) -> Planar | None:
        """Return the planar flow of this motion for the grid of ``flow``, None if the flow covers more.

        Raises
        ------
        ValueError
            The flow is of another image size than the model, or covers less than the motion, or more for more
            than 20 flows in a row.
        """
        check_size(self._model, flow)
        if not self._intervals.agrees(flow, motion):
            return None
        if self._series is not None:
            return planar(self._model, self._with_components(self._series, flow, motion), flow.interval_us)
        by_term = np.array([motion.forward_m**v * motion.turn_rad**w for v, w in self._powers])
        if self.odometry_error_ratio:
            by_term += self._correction(by_term, coarsen(flow, self._model.step_px))
        return planar(self._model, by_term.astype(np.float32) @ self._basis, flow.interval_us)

    def _correction(self, by_term: Doubles, cells: Flow) -> Doubles:
        """Return the correction of the factors of the terms, to first order."""
        rates = self._orders * by_term
        fields_px = np.array([-by_term, *rates], np.float32) @ self._basis
        uv_px, counts = vectors(cells, self._model)
        fields_px[0] += uv_px
        shares = correction(fields_px, counts.astype(np.float32), self.odometry_error_ratio)
        return np.asarray(shares @ rates)

    def _with_components(self, series: Series, flow: Flow, motion: graphnav.Motion) -> Doubles:
        """Return the planar flow of the motion and of the components that fit most of the flow, (2n,)."""
        uv_px, counts = vectors(coarsen(flow, self._model.step_px), self._model)
        odometry = np.array([motion.forward_m, motion.turn_rad])
        products = series.products(uv_px.astype(np.float64))
        return series.flow(
            bounded_motion(series, products, counts.astype(np.float64), odometry, self.odometry_error_ratio)
        )

    def _use(self, model: PlanarModel) -> None:
        terms, free = driving_terms(model.terms), free_terms(model.terms)
        if free and not terms:
            raise ParamError(
                "model",
                f"{self.model} was taught without odometry: its terms are {', '.join(model.terms)}",
                "write planar.subspace, which needs no odometry, or teach a model with odometry: wire 'motion' of "
                "planar.teach, with terms of v and w",
            )
        if not terms:
            raise self._not_taught("how the flow depends on the motion", model)
        self._series = None
        if free:
            fields = model.basis[[model.terms.index(term) for term in terms + free]]
            self._series = Series(fields.reshape(len(fields), -1).astype(np.float64), orders(terms))
        places = [model.terms.index(term) for term in terms]
        self._basis = model.basis[places].reshape(len(places), -1).astype(np.float32)
        self._orders = orders(terms)
        self._powers: list[list[float]] = self._orders.T.tolist()
        self._model = model


def bounded_motion(series: Series, products: Doubles, counts: Doubles, odometry: Doubles, max_share: float) -> Doubles:
    """Return the motion with which most of the flow agrees, (unknowns,), from a start at ``odometry`` (2,).

    ``products``: (products, n), of ``series``; ``counts``: (n,), 1 for a vector to fit, 0 for others. ``max_share``:
    maximum relative difference of v and w from odometry; the other factors are free.
    """
    reach = max_share * np.abs(odometry)
    low, high = odometry - reach, odometry + reach
    motion = np.concatenate([odometry, np.zeros(series.n_free)])
    for factor in FREE_NOISE_FACTORS:
        squares_px2 = series.squares(series.factors(motion)) @ products
        weight = weights(squares_px2, factor * NOISE_PX, counts)
        motion = series.step_within(motion, products @ weight, low, high)
    return motion


def correction(fields_px: Floats, counts: Floats, max_share: float) -> tuple[float, float]:
    """Return the relative corrections of the forward displacement and the turn.

    ``fields_px``: (3, 2n), flow minus planar flow, and the derivative of the planar flow by each correction; u
    and v of each vector in turn. ``counts``: (n,), 1 for a vector to fit, 0 for others. ``max_share``:
    limit of the corrections.

    Least squares, three times reweighted: a vector that differs by much more than flow noise, an obstacle's, has no
    weight (Geman and McClure's). It starts from odometry, so obstacles may cover more than the floor; the limit keeps
    the fit from following them.
    """
    products = _products(fields_px)
    # One plus the square of what the corrections s leave of a difference d: 1 + d.d - 2 s_i r_i.d + s_i s_j r_i.r_j.
    products[0] += 1
    forward, turn = 0.0, 0.0
    for _ in range(_ITERATIONS):
        of_products = [1.0, -2 * forward, -2 * turn, forward * forward, 2 * forward * turn, turn * turn]
        weight = np.array(of_products, np.float32) @ products
        weight *= weight
        np.divide(counts, weight, out=weight)
        _, vd, wd, vv, vw, ww = (products @ weight).tolist()
        vv, ww = vv + _RIDGE, ww + _RIDGE
        determinant = vv * ww - vw * vw
        forward = min(max((ww * vd - vw * wd) / determinant, -max_share), max_share)
        turn = min(max((vv * wd - vw * vd) / determinant, -max_share), max_share)
    return forward, turn


def _products(fields_px: Floats) -> Floats:
    """Return the products d.d, v.d, w.d, v.v, v.w and w.w of every vector of the fields d, v and w, (6, n).

    In units of the flow noise: a square of 1 is that of a vector that has half of its agreement.
    """
    fields_px = fields_px * np.float32(1 / NOISE_PX)
    products = np.empty((6, fields_px.shape[1]), np.float32)
    np.multiply(fields_px, fields_px[0], out=products[:3])
    np.multiply(fields_px[1:], fields_px[1], out=products[3:5])
    np.multiply(fields_px[2], fields_px[2], out=products[5])
    return np.add(products[:, ::2], products[:, 1::2])
