"""Stages of the family ``mapping``: from what a camera of known mounting sees to a map of the floor around the robot."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_mapping.egomotion import Egomotion
    from graphnav_mapping.local import Local

    return [Egomotion, Local]
