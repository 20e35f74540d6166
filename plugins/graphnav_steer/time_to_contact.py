"""Steering by time to contact, from the expansion of the flow."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np

from graphnav import Flow, Goal, Latest, Planar, Steering, coarsen, param
from graphnav_steer.forces import Forces

Divergence = Literal["full", "across"]

CELL_PX = 4
MIN_VECTORS = 6
"""An affine motion has six coefficients; from fewer than twice their number of components it is not fitted."""


class TimeToContact(Forces):
    """Time to contact on the left, in the middle and on the right, from the divergence of the flow.

    What approaches expands: with the divergence D of its flow, time to contact is 2 / D [NA, C]. D is that of an affine
    motion fitted to the valid vectors of each third of the picture. r points to the side that has longer, as long as
    ``gain_s`` times the difference of the inverse times, and back, as long as ``brake_s`` times the inverse time in the
    middle. A third that does not expand, or has fewer than 6 vectors on a grid of 4 px, has no end of time.

    The idea assumes a camera that looks ahead with a stabilised gaze. One that looks down sees an obstacle enter from
    above, faster than the floor below it: that edge is compressed, not expanded. So the expansion is
    measured across the picture alone by default, one of the directional divergences of [NA]. And where the camera turns
    with the robot and is tilted, the outer side expands in a turn, which reinforces the turn: with the
    camera of the shipped graphs a ``gain_s`` above 2 or so keeps it spinning.

    References
    ----------
    .. [NA] R. C. Nelson, J. Aloimonos, Obstacle Avoidance Using Flow Field Divergence, IEEE PAMI 11(10), 1989.
    .. [C] T. A. Camus, Calculating Time-to-Contact Using Real-Time Quantized Optical Flow, NISTIR 5609, 1995.
    """

    divergence: Divergence = param(
        "across", doc="full: what the flow expands along both axes; across: twice what it expands from left to right"
    )
    gain_s: float = param(
        1.5,
        gt=0.0,
        le=1e6,
        doc="r's length to the side where the inverse times differ by 1 per second; more turns harder",
    )
    brake_s: float = param(
        1.0,
        ge=0.0,
        le=1e6,
        doc="time to contact ahead at which r cancels w and the robot stands and turns; 0 never brakes",
    )

    def step(self, flow: Flow, goal: Latest[Goal], planar: Latest[Planar]) -> Steering:
        """Return the forces.

        Raises
        ------
        ValueError
            The guiding force is to come from the planar flow, and there is none.
        """
        cells = coarsen(flow, CELL_PX) if CELL_PX % flow.step_px == 0 else flow
        left, ahead, right = (
            inverse_time(cells, columns, self.divergence) for columns in _thirds(cells.valid.shape[1])
        )
        repulsive = np.array([self.gain_s * (left - right), -self.brake_s * ahead])
        guiding = self._guiding_force(goal.value, planar.value)
        return self._steering(repulsive, guiding, float(np.sign(right - left)))


def inverse_time(cells: Flow, columns: slice, divergence: Divergence) -> float:
    """Return one over the time to contact of what these columns show, 1/s, zero where nothing expands.

    ``divergence``: along both axes, or twice that across.
    """
    rows, cols = np.nonzero(cells.valid[:, columns])
    if len(rows) < MIN_VECTORS or not cells.interval_us:
        return 0.0
    places = np.stack([np.ones(len(rows)), cols, rows], axis=1)
    vectors = cells.uv_px[:, columns][rows, cols].astype(np.float64) / cells.step_px
    motion = np.linalg.lstsq(places, vectors, rcond=None)[0]
    per_frame = motion[1, 0] if divergence == "across" else (motion[1, 0] + motion[2, 1]) / 2
    return max(float(per_frame), 0.0) / (cells.interval_us * 1e-6)


def _thirds(cols: int) -> list[slice]:
    edges = [round(cols * k / 3) for k in range(4)]
    return [slice(begin, end) for begin, end in pairwise(edges)]
