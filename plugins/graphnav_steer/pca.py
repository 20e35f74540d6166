"""Steering of [OI]: along the principal direction of the obstacle potential's gradients."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from graphnav import Goal, Latest, Plane, Potential, Stage, Steering, param
from graphnav_steer.attention import cell_weights
from graphnav_steer.axes import AHEAD, angle_rad, toward, upright
from graphnav_steer.field import OBSTACLE_LEVEL, Field, obstacle_field
from graphnav_steer.principal import principal_direction

Doubles = npt.NDArray[np.float64]

LEAST_FORCE = 0.05
"""A control force shorter than this (the guiding force has length 1) has no direction."""
EVERYWHERE_RATIO = 0.9
"""From this share of obstacle on, there is no ground to tell it from."""
TINY = 1e-9


class PcaOutputs(NamedTuple):
    """What `Pca` publishes."""

    steering: Steering
    potential: Potential


class Pca(Stage):
    """Direction of attention from the principal direction of the obstacle potential's gradients.

    The potential is a wide Gaussian of the dominant map, computed on the map's own grid [OI, eq. 4 to 6]. Its gradients
    point to the obstacle; the repulsive force r points the other way, along their first principal direction [OI,
    eq. 7 and 8]. The paper leaves the sizes of the forces open: here the guiding force w has length 1 (forward, or to
    the goal's beacon) and r carries a strength. The control force is p = r + w [OI, eq. 9], theta its angle from
    forward, on the side of p's component to the right [OI, eq. 10].

    What else the paper leaves open:

    - No obstacle, no cell that was judged, or obstacles whose pushes cancel: r = 0.
    - Obstacles (nearly) everywhere: r points straight back and is at least as long as w.
    - Where p is next to nothing, theta is a right angle to the freer side, at which `control.nonholonomic` stops and
      turns; where p points straight back, it turns to that side. A tie goes to the side of the last turn, at first to
      the left.

    Departures from [OI], off by default, which a field of pillars needs and a corridor does not: ``bell_ratio`` and
    ``near_weight`` weigh the map before the Gaussian, ``backward: false`` drops the part of r that brakes. ``about:
    zero`` replaces the covariance of eq. 7: gradients that all point to one side differ little from their centroid, so
    that the covariance shows how they scatter and not where they point; about zero the sign is more often right.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 3.
    """

    sigma_ratio: float = param(
        0.5,
        gt=0.0,
        le=4.0,
        doc="standard deviation of the Gaussian, in picture widths; less sees only what is close by",
    )
    border: Literal["zero", "nearest"] = param(
        "zero", doc="what the Gaussian meets beyond the picture: no obstacle, or the outermost cell going on"
    )
    about: Literal["centroid", "zero"] = param(
        "centroid", doc="principal direction of the gradients' covariance (eq. 7), or of their second moment about zero"
    )
    isotropic_ratio: float = param(
        1.1, ge=1.0, doc="below this ratio of the eigenvalues the mean gradient's direction is taken instead"
    )
    strength: Literal["share", "gradient"] = param(
        "share", doc="what r's length grows with: the obstacle's share of the picture, or the mean gradient's length"
    )
    gain: float = param(
        4.0, gt=0.0, doc="r's length at a share of 1 (or where the mean gradient is 255 per sigma); w has length 1"
    )
    guiding: Literal["forward", "goal"] = param(
        "forward", doc="where w points: straight ahead, or to the goal's beacon (straight ahead while none is heard)"
    )
    goal_weight: float = param(
        1.0, ge=0.0, le=1.0, doc="how far w turns from straight ahead to the beacon; 1 points at it"
    )
    bell_ratio: float | None = param(
        None,
        gt=0.0,
        doc="standard deviation, in picture widths, of a bell that weighs the map's columns; null for none",
    )
    near_weight: float = param(
        1.0, ge=0.0, le=1.0, doc="weight of the map's lowest row; it grows to 1 at the highest; 1 weighs all rows alike"
    )
    backward: bool = param(True, doc="whether r may point backwards; without it r only turns the robot aside")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the side of the last turn."""
        self._last_side = 1.0

    def step(self, plane: Plane, goal: Latest[Goal]) -> PcaOutputs:
        """Return the forces and the potential that they come from."""
        weights = cell_weights(*plane.obstacle.shape, self.bell_ratio, self.near_weight)
        weighted = weights * plane.obstacle
        sigma_cells = self.sigma_ratio * plane.obstacle.shape[1]
        field = obstacle_field(weighted, sigma_cells, self.border)
        principal = principal_direction(field.gradient, self.about, self.isotropic_ratio)
        share = float(weighted.sum()) / max(float((weights * plane.valid).sum()), TINY)
        repulsive = self._repulsive_force(principal.direction, share, field, sigma_cells)
        guiding = self._guiding_force(goal.value)
        control = repulsive + guiding
        theta_rad = self._theta_rad(control, _freer_side(weighted))
        if theta_rad != 0.0:
            self._last_side = math.copysign(1.0, theta_rad)
        return PcaOutputs(
            Steering(
                repulsive=repulsive,
                guiding=guiding,
                control=control,
                theta_rad=theta_rad,
                eigenvalues=principal.eigenvalues,
            ),
            Potential(
                potential=field.potential.astype(np.float32),
                gradient=field.gradient.astype(np.float32),
                step_px=plane.step_px,
            ),
        )

    def _repulsive_force(self, obstacle: Doubles | None, share: float, field: Field, sigma_cells: float) -> Doubles:
        """Return r; ``obstacle`` is the direction to it (right, down)."""
        length = self.gain * share
        if self.strength == "gradient":
            mean = float(np.hypot(*field.gradient.mean(axis=(0, 1))))
            length = self.gain * mean * sigma_cells / OBSTACLE_LEVEL
        if share >= EVERYWHERE_RATIO:
            return -max(length, 1.0) * AHEAD
        if obstacle is None:
            return np.zeros(2)
        force = -length * upright(obstacle)
        return force if self.backward else np.array([force[0], max(force[1], 0.0)])

    def _guiding_force(self, goal: Goal | None) -> Doubles:
        if self.guiding == "forward" or goal is None:
            return AHEAD
        return toward(self.goal_weight * goal.bearing_rad)

    def _theta_rad(self, control: Doubles, freer_side: float) -> float:
        """Return the direction of ``control``, or a right angle to the freer side where it has none."""
        side = freer_side or self._last_side
        if np.hypot(*control) < LEAST_FORCE:
            return side * math.pi / 2
        if control[0] == 0.0 and control[1] < 0.0:
            return side * math.pi
        return angle_rad(control)


def _freer_side(weighted: Doubles) -> float:
    """Return 1.0 where the left half holds less obstacle than the right, -1.0 where it holds more, else 0.0."""
    half = weighted.shape[1] // 2
    left, right = weighted[:, :half].sum(), weighted[:, weighted.shape[1] - half :].sum()
    return float(np.sign(right - left))
