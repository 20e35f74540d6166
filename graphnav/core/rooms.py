"""The rooms beside the core: packages of graphnav with commands of their own, each of which may be missing.

The core imports no room. It asks for one by name where a command or a function needs it.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from importlib.util import find_spec
from types import ModuleType

from graphnav.core.errors import GraphnavError

ROOMS = ("live", "processes", "studies", "replay", "watch", "develop", "learning")


class MissingRoomError(GraphnavError):
    """A room is not installed."""


def rooms() -> Iterator[ModuleType]:
    """Yield the rooms that are installed: light packages, whose ``COMMANDS`` has every command and its help."""
    for name in ROOMS:
        if find_spec(f"graphnav.{name}") is not None:
            yield importlib.import_module(f"graphnav.{name}")


def linux_commands() -> frozenset[str]:
    """Return the commands of the rooms that work on Linux only."""
    return frozenset(name for room in rooms() for name in getattr(room, "LINUX_COMMANDS", ()))


def in_room(module: str) -> ModuleType:
    """Return a module of a room, such as ``"live.run"``.

    Raises
    ------
    MissingRoomError
        The room is not installed.
    """
    room = module.partition(".")[0]
    if find_spec(f"graphnav.{room}") is None:
        raise MissingRoomError(f"this needs graphnav.{room}, which is not installed\n  install graphnav again")
    return importlib.import_module(f"graphnav.{module}")
