"""The graphs that ship as environments of Gymnasium: importing this registers ``graphnav/NAME-v0`` of each closed loop.

``gymnasium.make("graphnav.gym:graphnav/corridor_ccw-v0")`` imports it, or ``gymnasium.register_envs(graphnav.gym)``.
A graph in a folder has a point in place of the slash: ``graphnav/navigate.maze-v0``. What `graphnav.make_env` takes are
keyword arguments of ``gymnasium.make``. Needs the extra ``gym``; no graph is read before an environment is made.
"""

from __future__ import annotations

from pathlib import Path

import graphnav_graphs

from graphnav import import_extra

OPEN = frozenset(
    {
        *("navigate_live", "navigate_recorded", "navigate_robot", "robot_live", "teach_live", "teach_recorded"),
        *("camera_flow", "video_plane", "video_prior"),
    }
)
"""Graphs without a simulated world that a command moves."""
_NO_GRAPHS = ("maps", "models", "parts", "studies")


def environments() -> dict[str, str]:
    """Return the ids of the environments, and the graph of each."""
    folder = Path(graphnav_graphs.__file__).parent
    paths = [path.relative_to(folder) for path in sorted((*folder.glob("*.yaml"), *folder.glob("*/*.yaml")))]
    names = [path.with_suffix("").as_posix() for path in paths if path.parts[0] not in _NO_GRAPHS]
    return {f"graphnav/{name.replace('/', '.')}-v0": name for name in names if name not in OPEN}


def _register() -> None:
    gymnasium = import_extra("gymnasium", "gym", "graphnav.gym")
    for name, graph in environments().items():
        if name not in gymnasium.registry:
            entry_point = "graphnav.learning.make_env:make_env"
            gymnasium.register(name, entry_point=entry_point, kwargs={"graph": graph})


_register()
