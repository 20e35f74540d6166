"""Steer away from the mean gradient of the obstacle potential: the baseline of eq. 7 of [OI]."""

from __future__ import annotations

from graphnav import Goal, Latest, Planar, Plane, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.potential import BACKWARD_DOC, BELL_DOC, GAIN_DOC, NEAR_DOC, STRENGTH_DOC, Potential, Strength
from graphnav_steer.principal import Principal, mean_direction


class MeanGradient(Potential):
    """Direction of the mean gradient of the obstacle potential.

    The simplest alternative to `steer.pca`: the same Gaussian of the dominant map and the same forces, but r points
    against the mean of the gradients, not along their principal direction. The mean of a field's gradients is the
    difference of its values at opposite borders, so this compares the four sides of the picture.

    Its defaults are not those of the paper, which `steer.pca` has, but those that work both in corridors and among
    pillars.
    """

    strength: Strength = param("gradient", doc=STRENGTH_DOC)
    gain: float = param(800.0, gt=0.0, le=1e6, doc=GAIN_DOC)
    bell_ratio: float | None = param(0.2, gt=0.0, le=1e6, doc=BELL_DOC)
    near_weight: float = param(0.0, ge=0.0, le=1.0, doc=NEAR_DOC)
    backward: bool = param(False, doc=BACKWARD_DOC)

    def step(self, plane: Plane, goal: Latest[Goal], planar: Latest[Planar]) -> Steering:
        """Return the forces.

        Raises
        ------
        ValueError
            The guiding force is to come from the planar flow, and there is none.
        """
        return self._forces(plane, goal.value, planar.value)[0]

    def _to_obstacle(self, gradient: Doubles) -> Principal:
        return mean_direction(gradient)
