"""Check that a motion and a flow cover the same interval."""

from __future__ import annotations

from graphnav import Flow, Motion

_MAX_ERROR_RATIO = 0.01
"""Tolerance, as a share of the flow's interval: a motion of other frames differs by far more."""
_MAX_LONGER = 20
"""Flows in a row that may cover more than the motion, before that is taken for odometry of another rate."""


class IntervalCheck:
    """Tells whether a motion covers the interval of a flow.

    A live flow that could not follow every image covers several motions, of which only the last is at hand: that is
    not an error, but such a flow has no motion.
    """

    def __init__(self) -> None:
        self._n_longer = 0

    def agrees(self, flow: Flow, motion: Motion) -> bool:
        """Whether the motion covers the flow's interval within 1 %; False if the flow covers more.

        Raises
        ------
        ValueError
            The motion covers more than the flow, or for more than 20 flows in a row less: the difference would look
            like an obstacle, or hide one.
        """
        longer_us = flow.interval_us - motion.interval_us
        if abs(longer_us) <= _MAX_ERROR_RATIO * flow.interval_us:
            self._n_longer = 0
            return True
        self._n_longer += 1
        if longer_us > 0 and self._n_longer <= _MAX_LONGER:
            return False
        why = f", {self._n_longer} times in a row" if longer_us > 0 else ""
        raise ValueError(
            f"the motion covers {motion.interval_us} us, but the flow {flow.interval_us} us{why}; "
            "use odometry.motion, which interpolates odometry over the interval of the flow"
            + (", or fewer or smaller images" if longer_us > 0 else "")
        )
