"""A second simulator of the same worlds: `world.mujoco`, drawn and driven by MuJoCo."""

from __future__ import annotations

from graphnav import Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of MuJoCo in the family ``world``."""
    from graphnav_mujoco.world import Mujoco

    return [Mujoco]
