"""Planar flow for the motion of the frame."""

from __future__ import annotations

import numpy as np

import graphnav
from graphnav import Flow, Planar, PlanarModel
from graphnav_planar.taught import Taught, planar
from graphnav_planar.terms import driving_terms, factors


class Motion(Taught):
    """Planar flow for the current motion, from the basis that `planar.teach` fitted.

    Extends [OI, eq. 1], whose mean holds for one constant motion, to a robot that turns. Beyond the motions that were
    taught the basis errs, and what it errs by looks like an obstacle: teach more than the controller may command.
    """

    def step(self, flow: Flow, motion: graphnav.Motion) -> Planar:
        """Return the planar flow of this motion for the grid of ``flow``.

        Raises
        ------
        ValueError
            The flow is of another image size than the model.
        """
        uv_px = factors(self._terms, motion) @ self._basis
        return planar(self._model, uv_px.reshape(*self._model.valid.shape, 2), flow)

    def _use(self, model: PlanarModel) -> None:
        self._terms = driving_terms(model.terms)
        if not self._terms:
            raise self._not_taught("how the flow depends on the motion", model)
        places = [model.terms.index(term) for term in self._terms]
        self._basis = model.basis[places].reshape(len(places), -1).astype(np.float64)
        self._model = model
