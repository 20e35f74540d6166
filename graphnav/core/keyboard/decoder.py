"""Decode the bytes of a terminal into keys."""

from __future__ import annotations

import re

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_SEQUENCE = re.compile(r"\x1b(?:O(?P<application>.)|\[(?P<arguments>[0-?]*[ -/]*)(?P<normal>[@-~]))", re.DOTALL)
_BEGUN = re.compile(r"\x1b(?:O|\[[0-?]*[ -/]*)?")
_MAX_BEGUN = 32


class KeyDecoder:
    """Decodes bytes into keys: lower-case characters, and ``up``, ``down``, ``left``, ``right``.

    The escape sequence of an arrow may arrive in pieces. Other sequences are ignored.
    """

    def __init__(self) -> None:
        self._begun = ""

    def feed(self, data: bytes) -> list[str]:
        """Return the keys that ``data`` completes."""
        text, self._begun = self._begun + data.decode("latin-1"), ""
        keys = []
        at = 0
        while at < len(text):
            if sequence := _SEQUENCE.match(text, at):
                arrow = _ARROWS.get(sequence["application"] or sequence["normal"])
                if arrow and not sequence["arguments"]:
                    keys.append(arrow)
                at = sequence.end()
            elif _BEGUN.fullmatch(text, at) and len(text) - at < _MAX_BEGUN:
                self._begun = text[at:]
                break
            else:
                keys.append(text[at].lower())
                at += 1
        return keys
