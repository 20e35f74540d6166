"""Base of steering by the obstacle potential: a force along a direction of its gradients."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

import graphnav
from graphnav import Goal, Planar, Plane, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.attention import cell_weights
from graphnav_steer.axes import AHEAD, upright
from graphnav_steer.field import OBSTACLE_LEVEL, Field, obstacle_field
from graphnav_steer.forces import Forces
from graphnav_steer.principal import Principal, mean_gradient
from graphnav_steer.unjudged import RIM_DOC, UNJUDGED_DOC, Unjudged, with_unjudged

Strength = Literal["share", "gradient", "unit"]

STRENGTH_DOC = (
    "strength of r: the obstacle's share of the picture, the length of the mean gradient, or unit: one length whenever "
    "there is an obstacle, as that of v1 in [OI, eq. 8]"
)
GAIN_DOC = (
    "dimensionless: length of r at a share of 1 (or where the mean gradient is 255 per sigma; if unit, always); w has "
    "length 1"
)
BELL_DOC = "standard deviation, in picture widths, of a bell that weighs the map's columns; null for none"
NEAR_DOC = "dimensionless: weight of the map's lowest row; it grows to 1 at the highest; 1 weighs all rows alike"
BACKWARD_DOC = "whether r may point backwards; otherwise r only turns the robot aside"

EVERYWHERE_RATIO = 0.9
"""At this share of obstacle and above, there is not enough ground to compare with."""
TINY = 1e-9


class Potential(Forces):
    """A stage that steers away from a wide Gaussian of the dominant map, along one direction of its gradients."""

    sigma_ratio: float = param(
        0.5,
        ge=0.01,
        le=4.0,
        doc="standard deviation of the Gaussian, in picture widths; less sees only what is close by",
    )
    border: Literal["zero", "nearest"] = param(
        "zero", doc="assumption beyond the picture: no obstacle, or the outermost cell repeated"
    )
    strength: Strength = param("share", doc=STRENGTH_DOC)
    gain: float = param(4.0, gt=0.0, le=1e6, doc=GAIN_DOC)
    bell_ratio: float | None = param(None, gt=0.0, le=1e6, doc=BELL_DOC)
    near_weight: float = param(1.0, ge=0.0, le=1.0, doc=NEAR_DOC)
    backward: bool = param(True, doc=BACKWARD_DOC)
    unjudged: Unjudged = param("obstacle", doc=UNJUDGED_DOC)
    rim_ratio: float = param(Plane.RIM_RATIO, ge=0.0, le=0.4, doc=RIM_DOC)

    def _to_obstacle(self, gradient: Doubles) -> Principal:
        """Return the direction of gradients (rows, cols, 2)."""
        raise NotImplementedError

    def _forces(self, plane: Plane, goal: Goal | None, planar: Planar | None) -> tuple[Steering, graphnav.Potential]:
        """Return the forces and the potential from which they derive."""
        weights = cell_weights(*plane.obstacle.shape, self.bell_ratio, self.near_weight)
        obstacle, counted = with_unjudged(plane, self.unjudged, self.rim_ratio)
        weighted = weights * obstacle
        sigma_cells = self.sigma_ratio * plane.obstacle.shape[1]
        field = obstacle_field(weighted, sigma_cells, self.border)
        found = self._to_obstacle(field.gradient)
        columns = weighted.sum(axis=0).tolist()
        share = sum(columns) / max(float(np.vdot(weights, counted)), TINY)
        repulsive = self._repulsive_force(found.direction, share, field, sigma_cells)
        guiding = self._guiding_force(goal, planar)
        return (
            self._steering(repulsive, guiding, _freer_side(columns), found.eigenvalues),
            graphnav.Potential(
                potential=field.potential.astype(np.float32),
                gradient=field.gradient.astype(np.float32),
                step_px=plane.step_px,
            ),
        )

    def _repulsive_force(self, obstacle: Doubles | None, share: float, field: Field, sigma_cells: float) -> Doubles:
        """Return r; ``obstacle`` is the direction to it (right, down)."""
        length = self.gain if self.strength == "unit" else self.gain * share
        if self.strength == "gradient":
            mean = math.hypot(*mean_gradient(field.gradient))
            length = self.gain * mean * sigma_cells / OBSTACLE_LEVEL
        if share >= EVERYWHERE_RATIO:
            return -max(length, 1.0) * AHEAD
        if obstacle is None:
            return np.zeros(2)
        force = -length * upright(obstacle)
        return force if self.backward else np.array([force[0], max(force[1], 0.0)])


def _freer_side(columns: list[float]) -> float:
    """Return 1.0 where the left half holds less obstacle than the right, -1.0 where it holds more, else 0.0.

    ``columns``: the obstacle in each column. Both halves are added from the border inwards, so that equal ones tie.
    """
    half = len(columns) // 2
    left, right = sum(columns[:half]), sum(columns[::-1][:half])
    return float((left < right) - (left > right))
