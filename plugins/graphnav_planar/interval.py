"""Check that a motion and a flow cover the same interval."""

from __future__ import annotations

from graphnav import Flow, Motion

MAX_ERROR_RATIO = 0.01
"""Tolerance, as a share of the flow's interval: a motion of other frames differs by far more."""


def check_interval(flow: Flow, motion: Motion) -> None:
    """Check that the motion covers the flow's interval, within 1 %.

    Raises
    ------
    ValueError
        It does not: the difference would look like an obstacle, or hide one.
    """
    if abs(motion.interval_us - flow.interval_us) > MAX_ERROR_RATIO * flow.interval_us:
        raise ValueError(
            f"the motion covers {motion.interval_us} us, but the flow {flow.interval_us} us; "
            "use odometry.motion, which interpolates odometry over the interval of the flow"
        )
