"""A contact sheet of the pictures of a calibration: the corners that were found, and why a picture was refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Self

import cv2
import numpy as np

from graphnav import Place, UserError, written_aside
from graphnav.arrays import Bytes, Doubles

TILE_COLS = 320
_LINE_ROWS, _LINES = 14, 3
_SHOWN_CHARS = 50
_GOOD, _BAD, _INK = (60, 150, 40), (40, 40, 210), (20, 20, 20)
"""Blue, green, red, as OpenCV writes."""
_MAX_ACROSS = 5


class Tile(NamedTuple):
    """A picture of the sheet: small, uint8 (rows, 320, 3), with its corners drawn."""

    name: str
    pixels: Bytes
    refusal: str = ""
    before: str = ""

    @classmethod
    def of(cls, name: str, gray: Bytes, points_px: Doubles) -> Self:
        """Return the tile of a picture; one that could not be read is an empty one."""
        if not gray.size:
            return cls(name, np.full((TILE_COLS * 3 // 4, TILE_COLS, 3), 200, np.uint8))
        scale = TILE_COLS / gray.shape[1]
        size = TILE_COLS, max(1, round(gray.shape[0] * scale))
        small = cv2.cvtColor(cv2.resize(gray, size, interpolation=cv2.INTER_AREA), cv2.COLOR_GRAY2BGR)
        for x, y in ((points_px + 0.5) * scale - 0.5).tolist():
            cv2.circle(small, (round(x * 16), round(y * 16)), 3 * 16, (0, 140, 255), 1, cv2.LINE_AA, shift=4)
        return cls(name, np.asarray(small, np.uint8))

    def judged(self, refusal: str, before: str = "") -> Tile:
        """Return the tile with the reason why it is not used, empty if it is; ``before``: in front of its name."""
        return self._replace(refusal=refusal, before=before)

    def drawn(self, rows: int) -> Bytes:
        """Return the tile with a frame and its text, its picture in ``rows`` rows."""
        colour = _BAD if self.refusal else _GOOD
        tile = np.full((rows + _LINE_ROWS * (1 + _LINES) + 8, TILE_COLS + 8, 3), 255, np.uint8)
        tile[4 : 4 + len(self.pixels), 4:-4] = self.pixels
        cv2.rectangle(tile, (1, 1), (TILE_COLS + 6, rows + 6), colour, 3)
        lines = [(self.before + self.name, _INK), *((line, colour) for line in _wrapped(self.refusal or "used"))]
        for number, (line, ink) in enumerate(lines[: 1 + _LINES]):
            at = 6, rows + 8 + _LINE_ROWS * (number + 1) - 4
            plain = line.encode("ascii", "replace").decode()[:_SHOWN_CHARS]
            cv2.putText(tile, plain, at, cv2.FONT_HERSHEY_SIMPLEX, 0.4, ink, 1, cv2.LINE_AA)
        return tile


def write_sheet(file: Path, tiles: Sequence[Tile]) -> None:
    """Write tiles side by side as PNG.

    Raises
    ------
    UserError
        The file cannot be written.
    """
    rows = max((len(tile.pixels) for tile in tiles), default=TILE_COLS)
    across = min(_MAX_ACROSS, max(1, len(tiles)))
    drawn = [tile.drawn(rows) for tile in tiles] or [np.full((rows, TILE_COLS, 3), 255, np.uint8)]
    drawn += [np.full_like(drawn[0], 255)] * (math.ceil(len(drawn) / across) * across - len(drawn))
    sheet = np.vstack([np.hstack(drawn[first : first + across]) for first in range(0, len(drawn), across)])
    data = cv2.imencode(".png", sheet)[1].tobytes()
    try:
        with written_aside(file) as aside:
            aside.write_bytes(data)
    except OSError as error:
        raise UserError.of(f"cannot write {file}: {error.strerror}", "choose another file", Place("-o")) from error


def _wrapped(text: str) -> list[str]:
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > _SHOWN_CHARS - 4:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
