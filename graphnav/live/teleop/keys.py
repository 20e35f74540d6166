"""Keys of teleop and their meaning."""

from __future__ import annotations

from enum import Enum, auto

from graphnav.core.keyboard import KeyDecoder


class Key(Enum):
    """The meaning of a key."""

    FORWARD = auto()
    BACK = auto()
    LEFT = auto()
    RIGHT = auto()
    HALT = auto()
    FASTER = auto()
    SLOWER = auto()
    STOP = auto()
    ARM = auto()
    QUIT = auto()


HELP = """\
  w or i or up     forward        x  stop the robot until it is re-armed
  s or k or down   back           r  re-arm it
  a or j or left   turn left      +  faster
  d or l or right  turn right     -  slower
  space            halt           q  quit
"""

_KEYS = {
    **dict.fromkeys(("w", "i", "up"), Key.FORWARD),
    **dict.fromkeys(("s", "k", "down"), Key.BACK),
    **dict.fromkeys(("a", "j", "left"), Key.LEFT),
    **dict.fromkeys(("d", "l", "right"), Key.RIGHT),
    **dict.fromkeys("+=", Key.FASTER),
    **dict.fromkeys("-_", Key.SLOWER),
    " ": Key.HALT,
    "x": Key.STOP,
    "r": Key.ARM,
    "q": Key.QUIT,
}


class Keys:
    """Decodes the bytes of a terminal; keys without a meaning are ignored."""

    def __init__(self) -> None:
        self._decoder = KeyDecoder()

    def feed(self, data: bytes) -> list[Key]:
        """Return the keys that ``data`` completes."""
        return [_KEYS[name] for name in self._decoder.feed(data) if name in _KEYS]
