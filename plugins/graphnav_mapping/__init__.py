"""Stages of the family ``mapping``: from the view of a camera of known mounting to a map of the floor."""

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family."""
    from graphnav_mapping.egomotion import Egomotion
    from graphnav_mapping.local import Local

    return [Egomotion, Local]
