"""Planar flow for the motion of the frame, from odometry."""

from __future__ import annotations

import numpy as np

import graphnav
from graphnav import Flow, ParamError, Planar, PlanarModel, coarsen, param
from graphnav.arrays import Doubles
from graphnav_planar.estimation.bounded import bounded_motion
from graphnav_planar.estimation.refinement import correction
from graphnav_planar.estimation.series import Series
from graphnav_planar.interval import check_interval
from graphnav_planar.taught import Taught, check_size, planar, vectors
from graphnav_planar.terms import driving_terms, free_terms, orders


class Motion(Taught):
    """Planar flow for the current motion, from the basis that `planar.teach` fitted.

    Extends [OI, eq. 1], whose mean holds for one constant motion, to a robot that turns. Outside the taught
    motions the basis is inaccurate, and the error looks like an obstacle: teach more than the controller may command.

    An odometry error of two per cent shifts the planar flow by a tenth of a pixel in a turn, as much as a low obstacle
    does. So the motion is corrected, within ``odometry_error_ratio``, to agree with most of the flow.

    Odometry does not know how a camera pitches, rolls and bounces. A model with principal components (``components`` of
    `planar.teach`) has their flow: their factors are free, and fitted together with the correction. A model of
    components alone, taught without odometry, is for `planar.subspace`.
    """

    odometry_error_ratio: float = param(
        0.1,
        ge=0.0,
        lt=1.0,
        doc="maximum relative correction of the motion to fit the flow: the error of odometry, when teaching and now; "
        "0 does not correct it",
    )

    def step(self, flow: Flow, motion: graphnav.Motion) -> Planar:
        """Return the planar flow of this motion for the grid of ``flow``.

        Raises
        ------
        ValueError
            The flow is of another image size than the model, or covers another interval than the motion.
        """
        check_size(self._model, flow)
        check_interval(flow, motion)
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
