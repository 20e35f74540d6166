"""Steer like bees: balance the flow on both sides."""

from __future__ import annotations

import numpy as np

from graphnav import Flow, Goal, Latest, Planar, Steering, param
from graphnav_steer.forces import Forces


class Balance(Forces):
    """Balance of the flow on the left and on the right.

    Near things flow faster, so the robot turns away from the side with more flow: r points sideways, as long as
    ``gain`` times the difference of the mean lengths of the valid vectors in the two halves of the picture, divided by
    their sum [SK, BEE]. It needs neither a planar flow nor a detector.

    The idea assumes eyes that look sideways and a body that does not turn. A camera that looks down sees mostly floor:
    an obstacle flows only a little faster, and in a turn the outer side flows faster than the inner one, which
    reinforces the turn. With the camera of the shipped graphs that alone sustains a turn from a ``gain`` of about 0.7;
    with a little less the small difference of a wall is not enough, with much more the robot spins.

    References
    ----------
    .. [SK] K. Souhila, A. Karim, Optical Flow Based Robot Obstacle Avoidance, International Journal of Advanced
       Robotic Systems 4(1), 2007.
    .. [BEE] M. V. Srinivasan, M. Lehrer, W. H. Kirchner, S. W. Zhang, Range Perception Through Apparent Image Speed
       in Freely Flying Honeybees, Visual Neuroscience 6, 1991.
    """

    gain: float = param(
        0.7, gt=0.0, le=1e6, doc="dimensionless: length of r where all flow is on one side; w has length 1"
    )

    def step(self, flow: Flow, goal: Latest[Goal], planar: Latest[Planar]) -> Steering:
        """Return the forces; without valid vectors on both sides r is zero.

        Raises
        ------
        ValueError
            The guiding force is to come from the planar flow, and there is none.
        """
        more_left = _more_on_the_left(flow)
        guiding = self._guiding_force(goal.value, planar.value)
        return self._steering(np.array([self.gain * more_left, 0.0]), guiding, -np.sign(more_left))


def _more_on_the_left(flow: Flow) -> float:
    """Return the difference of the two halves' mean lengths of flow by their sum, -1 to 1."""
    length, valid = np.hypot(flow.uv_px[..., 0], flow.uv_px[..., 1]), flow.valid != 0
    half = length.shape[1] // 2
    sides = (slice(0, half), slice(length.shape[1] - half, None))
    counts = [np.count_nonzero(valid[:, side]) for side in sides]
    if not all(counts):
        return 0.0
    left, right = (
        float(length[:, side].sum(where=valid[:, side], dtype=np.float64)) / count
        for side, count in zip(sides, counts, strict=True)
    )
    return (left - right) / (left + right) if left + right > 0.0 else 0.0
