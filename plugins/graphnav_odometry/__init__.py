"""Stages of the family ``odometry``: from a robot's odometry to the motion of a frame."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_odometry.motion import Motion

    return [Motion]
