"""Whether a motion is that of a flow: over the same time."""

from __future__ import annotations

from graphnav import Flow, Motion

MAX_ERROR_RATIO = 0.01
"""What the two intervals may differ by, as a share of the flow's: a motion of other frames differs by far more."""


def check_interval(flow: Flow, motion: Motion) -> None:
    """See that the motion covers the flow's interval, within 1 %.

    Raises
    ------
    ValueError
        It does not: what it is wrong by would look like an obstacle, or hide one.
    """
    if abs(motion.interval_us - flow.interval_us) > MAX_ERROR_RATIO * flow.interval_us:
        raise ValueError(
            f"the motion covers {motion.interval_us} us, but the flow {flow.interval_us} us; "
            "use odometry.motion, which interpolates odometry over the interval of the flow"
        )
