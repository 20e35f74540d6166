"""The simulated world that closes the loop: `world.pymunk`, and as a robot on a bus: `world.robot`."""

from __future__ import annotations

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family ``world``."""
    from graphnav_world.robot import Robot
    from graphnav_world.world import Pymunk

    return [Pymunk, Robot]
