"""Stages of the family ``mapping``: from a camera of known mounting, or a lidar, to a map of the floor."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_mapping.egomotion import Egomotion
    from graphnav_mapping.lidar import Lidar
    from graphnav_mapping.local import Local

    return [Egomotion, Lidar, Local]
