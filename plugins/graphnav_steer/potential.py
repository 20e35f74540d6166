"""Base of steering by the obstacle potential: a force along a direction of its gradients."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

import graphnav
from graphnav import Goal, Planar, Plane, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.axes import AHEAD, upright
from graphnav_steer.forces import Forces
from graphnav_steer.principal import Principal, mean_gradient
from graphnav_steer.unjudged import RIM_DOC, UNJUDGED_DOC, Unjudged, with_unjudged

Strength = Literal["share", "gradient", "unit"]
Border = Literal["zero", "nearest"]
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
OBSTACLE_LEVEL = 255.0
"""Weight of an obstacle in the potential [OI, eq. 4]."""
REACH = 5.0
"""Truncation of the Gaussian in standard deviations; the loss is below one millionth."""


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


class Field(NamedTuple):
    """``potential`` (rows, cols) and its ``gradient`` (rows, cols, 2), right and down, per cell."""

    potential: Doubles
    gradient: Doubles


def obstacle_field(weighted: Doubles, sigma_cells: float, border: Border) -> Field:
    """Return the obstacle potential, G_sigma * (255 d), and its gradient [OI, eq. 4 to 6].

    ``weighted``: (rows, cols), d, or d times a weight. ``border``: the assumption beyond the grid, "zero" (no
    obstacle, as in the integral) or "nearest" (the outermost cell is repeated). The Gaussian is normalised; the
    gradient is the convolution with its derivative, so that no differences are taken at the border. Matrices are
    cached.
    """
    rows, cols = weighted.shape
    smooth_y, slope_y = _matrices(rows, sigma_cells, border)
    along_x = weighted @ _matrices_x(cols, sigma_cells, border)
    potential_and_right = smooth_y @ along_x
    gradient = np.empty((rows, cols, 2))
    gradient[..., 0] = potential_and_right[:, cols:]
    gradient[..., 1] = slope_y @ along_x[:, :cols]
    return Field(potential_and_right[:, :cols], gradient)


@lru_cache(maxsize=16)
def _matrices_x(cells: int, sigma_cells: float, border: Border) -> Doubles:
    """Return the matrix that smooths rows, beside that which differentiates them, (cells, 2 cells), times 255."""
    matrix: Doubles = OBSTACLE_LEVEL * np.concatenate(_matrices(cells, sigma_cells, border)).T
    matrix = np.ascontiguousarray(matrix)
    matrix.setflags(write=False)
    return matrix


@lru_cache(maxsize=16)
def _matrices(cells: int, sigma_cells: float, border: Border) -> tuple[Doubles, Doubles]:
    """Return the matrices that smooth ``cells`` values and differentiate the result, both (cells, cells)."""
    reach = math.ceil(REACH * sigma_cells)
    distance = np.arange(-reach - cells, reach + cells + 1, dtype=np.float64)
    kernel = np.exp(-0.5 * (distance / sigma_cells) ** 2)
    kernel /= kernel.sum()
    slope = -distance / sigma_cells**2 * kernel
    return _toeplitz(kernel, cells, border), _toeplitz(slope, cells, border)


def _toeplitz(kernel: Doubles, cells: int, border: Border) -> Doubles:
    """Return the matrix whose row i holds ``kernel`` centred on i; with "nearest" its ends are added to the edges."""
    middle = len(kernel) // 2
    inside = np.arange(cells)
    matrix: Doubles = kernel[middle + inside[:, None] - inside[None, :]]
    if border == "nearest":
        tail = np.cumsum(kernel)
        matrix[:, 0] += kernel.sum() - tail[middle + inside]
        matrix[:, -1] += tail[middle + inside - cells]
    matrix.setflags(write=False)
    return matrix


@lru_cache(maxsize=16)
def cell_weights(rows: int, cols: int, bell_ratio: float | None, near_weight: float) -> Doubles:
    """Return the weight of every cell of the dominant map, (rows, cols), at most 1.

    ``bell_ratio``: standard deviation of a bell across the picture, in picture widths; None for none.
    ``near_weight``: weight of the lowest row, from where it grows linearly to 1 at the highest.
    """
    across = np.ones(cols)
    if bell_ratio is not None:
        across = np.exp(-0.5 * ((np.arange(cols) - (cols - 1) / 2) / (bell_ratio * cols)) ** 2)
    weights: Doubles = np.linspace(1.0, near_weight, rows)[:, None] * across
    weights.setflags(write=False)
    return weights
