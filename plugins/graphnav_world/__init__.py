"""Simulated worlds that close the loop: `world.pymunk`, `world.lidar`, and `world.robot`, a robot on a bus."""

from __future__ import annotations

from typing import Any

from graphnav import FileFormat, Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages of the family ``world``."""
    from graphnav_world.lidar import Lidar
    from graphnav_world.robot import Robot
    from graphnav_world.world import Pymunk

    return [Lidar, Pymunk, Robot]


@hookimpl
def graphnav_file_formats() -> list[FileFormat[Any]]:
    """Return the format of maps."""
    from graphnav_world.maps.map_format import MAP

    return [MAP]
