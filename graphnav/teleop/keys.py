"""What the bytes of a terminal mean."""

from __future__ import annotations

import re
from enum import Enum, auto


class Key(Enum):
    """What a key asks for."""

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
  w or i or up     forward        x  stop the robot until it is armed again
  s or k or down   back           r  arm it again
  a or j or left   turn left      +  faster
  d or l or right  turn right     -  slower
  space            halt           q  quit
"""

_LETTERS = {
    **dict.fromkeys("wi", Key.FORWARD),
    **dict.fromkeys("sk", Key.BACK),
    **dict.fromkeys("aj", Key.LEFT),
    **dict.fromkeys("dl", Key.RIGHT),
    **dict.fromkeys("+=", Key.FASTER),
    **dict.fromkeys("-_", Key.SLOWER),
    " ": Key.HALT,
    "x": Key.STOP,
    "r": Key.ARM,
    "q": Key.QUIT,
}
_ARROWS = {"A": Key.FORWARD, "B": Key.BACK, "C": Key.RIGHT, "D": Key.LEFT}
_SEQUENCE = re.compile(r"\x1b(?:O(?P<application>.)|\[(?P<arguments>[0-?]*[ -/]*)(?P<normal>[@-~]))", re.DOTALL)
_BEGUN = re.compile(r"\x1b(?:O|\[[0-?]*[ -/]*)?")
_MAX_BEGUN = 32


class KeyDecoder:
    """Turns bytes into keys; an arrow's sequence may come in pieces. What means nothing is left out."""

    def __init__(self) -> None:
        self._begun = ""

    def feed(self, data: bytes) -> list[Key]:
        """Return the keys that ``data`` completes."""
        text, self._begun = self._begun + data.decode("latin-1"), ""
        keys: list[Key | None] = []
        at = 0
        while at < len(text):
            if sequence := _SEQUENCE.match(text, at):
                plain = not sequence["arguments"]
                keys.append(_ARROWS.get(sequence["application"] or sequence["normal"]) if plain else None)
                at = sequence.end()
            elif _BEGUN.fullmatch(text, at) and len(text) - at < _MAX_BEGUN:
                self._begun = text[at:]
                break
            else:
                keys.append(_LETTERS.get(text[at].lower()))
                at += 1
        return [key for key in keys if key is not None]
