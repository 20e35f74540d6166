"""Steering of [OI], along the principal direction of the obstacle potential's gradients."""

from __future__ import annotations

from typing import Literal, NamedTuple

import graphnav
from graphnav import Goal, Latest, Planar, Plane, Steering, param
from graphnav.arrays import Doubles
from graphnav_steer.forces import GUIDING_DOC, Guiding
from graphnav_steer.potential import Potential
from graphnav_steer.principal import Principal, principal_direction


class PcaOutputs(NamedTuple):
    """Outputs of `Pca`."""

    steering: Steering
    potential: graphnav.Potential


class Pca(Potential):
    """Direction of attention from the principal direction of the obstacle potential's gradients.

    The potential is a wide Gaussian of the dominant map, computed on the map's own grid [OI, eq. 4 to 6]. Its gradients
    point to the obstacle; the repulsive force r points the other way, along their first principal direction [OI,
    eq. 7 and 8]. The paper leaves the sizes of the forces open: here the guiding force w has length 1 (forward, or to
    the goal's beacon) and r carries a strength. The control force is p = r + w [OI, eq. 9], theta its angle from
    forward, on the side of p's component to the right [OI, eq. 10].

    Other cases that the paper leaves open:

    - No obstacle, or obstacles whose forces cancel: r = 0.
    - A cell that was not judged, although it lies inside the rim of the picture, counts as an obstacle: unknown is not
      free (``unjudged``).
    - Obstacles (nearly) everywhere: r points straight back and is at least as long as w.
    - Where p is nearly zero, theta is a right angle to the freer side, at which `control.nonholonomic` stops and
      turns; where p points straight back, it turns to that side. A tie goes to the side of the last turn, at first to
      the left.

    Departures from [OI], off by default, which a field of pillars needs and a corridor does not: ``bell_ratio`` and
    ``near_weight`` weigh the map before the Gaussian, ``backward: false`` drops the part of r that brakes. ``about:
    zero`` replaces the covariance of eq. 7: gradients that all point to one side differ little from their centroid, so
    that the covariance shows their scatter instead of their direction; about zero the sign is more often right.

    References
    ----------
    .. [OI] N. Ohnishi, A. Imiya, Combination of Supervised and Unsupervised Methods for Navigation Path Mining,
       section 3.
    """

    guiding: Guiding = param("forward", doc=GUIDING_DOC)
    about: Literal["centroid", "zero"] = param(
        "centroid", doc="principal direction of the gradients' covariance (eq. 7), or of their second moment about zero"
    )
    isotropic_ratio: float = param(
        1.1,
        ge=1.0,
        le=1e6,
        doc="below this ratio of the eigenvalues the direction of the mean gradient is used instead",
    )

    def step(self, plane: Plane, goal: Latest[Goal], planar: Latest[Planar]) -> PcaOutputs:
        """Return the forces and the potential from which they derive.

        Raises
        ------
        ValueError
            The guiding force is to come from the planar flow, and there is none.
        """
        return PcaOutputs(*self._forces(plane, goal.value, planar.value))

    def _to_obstacle(self, gradient: Doubles) -> Principal:
        return principal_direction(gradient, self.about, self.isotropic_ratio)
