"""Base of all steering by forces: the guiding force, the control force and its angle."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from graphnav import Goal, Planar, Stage, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.axes import AHEAD, angle_rad, toward, upright

Guiding = Literal["forward", "goal", "flow"]

GUIDING_DOC = (
    "where w points: straight ahead, to the goal's beacon (straight ahead while none is heard), or against the mean "
    "planar flow, which turns where the robot turns now (straight ahead while it stands)"
)
MIN_FORCE = 0.05
"""A control force shorter than this (the guiding force has length 1) has no direction."""
MIN_FLOW_PX = 0.01
"""A mean planar flow shorter than this has no direction: the robot stands."""


class Forces(Stage):
    """A stage that adds a repulsive force r to a guiding force w of length 1 and steers along p = r + w."""

    guiding: Guiding = param("goal", doc=GUIDING_DOC)
    goal_weight: float = param(
        1.0, ge=0.0, le=1.0, doc="dimensionless: how far w turns from straight ahead to the beacon; 1 points at it"
    )
    flow_weight: float = param(
        0.5,
        ge=0.0,
        le=1.0,
        doc="dimensionless: how far w turns from straight ahead to the direction against the mean planar flow; 1 "
        "points against it, so that a robot that turns on the spot keeps turning",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the side of the last turn."""
        self._last_side = 1.0
        self._awaits_planar = True

    def _guiding_force(self, goal: Goal | None, planar: Planar | None) -> Doubles:
        """Return w, (right, forward).

        Raises
        ------
        ValueError
            It is to come from the planar flow, and from the second step on there is none.
        """
        if self.guiding == "goal" and goal is not None:
            return toward(self.goal_weight * goal.bearing_rad)
        if self.guiding == "flow":
            if planar is not None:
                return toward(self.flow_weight * angle_rad(_against(planar)))
            # In the first step the planar flow may be a stage behind.
            if not self._awaits_planar:
                raise ValueError(
                    "guiding is 'flow', but no planar flow is connected: --set steer.in.planar=planar.planar"
                )
            self._awaits_planar = False
        return AHEAD

    def _steering(
        self, repulsive: Doubles, guiding: Doubles, freer_side: float, eigenvalues: Doubles | None = None
    ) -> Steering:
        """Return the forces and their angle.

        ``freer_side``: 1.0 for left, -1.0 for right, 0.0 for neither. Where p is next to nothing, theta is a right
        angle to that side; where it points straight back, theta turns there. Neither means the side of the last turn.
        """
        control = repulsive + guiding
        theta_rad = self._theta_rad(control, freer_side or self._last_side)
        if theta_rad != 0.0:
            self._last_side = math.copysign(1.0, theta_rad)
        return Steering(
            repulsive=repulsive,
            guiding=guiding,
            control=control,
            theta_rad=theta_rad,
            eigenvalues=np.zeros(2) if eigenvalues is None else eigenvalues,
        )

    def _theta_rad(self, control: Doubles, side: float) -> float:
        if math.hypot(*control.tolist()) < MIN_FORCE:
            return side * math.pi / 2
        if control[0] == 0.0 and control[1] < 0.0:
            return side * math.pi
        return angle_rad(control)


def _against(planar: Planar) -> Doubles:
    """Return a vector (right, forward) against the mean planar flow, forward where there is none."""
    vectors = planar.planar_uv_px[planar.planar_valid != 0]
    if not len(vectors):
        return AHEAD
    force = -upright(vectors.mean(axis=0, dtype=np.float64))
    return force if np.hypot(*force) >= MIN_FLOW_PX else AHEAD
