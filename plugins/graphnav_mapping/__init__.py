"""Stages of the family ``mapping``: a map of the floor, from what a camera of known mounting sees."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_mapping.egomotion import Egomotion
    from graphnav_mapping.local import Local

    return [Egomotion, Local]
