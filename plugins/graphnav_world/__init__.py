"""The simulated world that closes the loop: `world.pymunk`, and as a robot on a bus: `world.robot`."""

from __future__ import annotations

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family ``world``."""
    from graphnav_world.robot import Robot  # noqa: PLC0415  # cv2 and pymunk load only when the family is asked for
    from graphnav_world.world import Pymunk  # noqa: PLC0415

    return [Pymunk, Robot]
