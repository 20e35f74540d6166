"""Text in video frames."""

from __future__ import annotations

from typing import Literal

import cv2

from graphnav.arrays import Bytes

Colour = tuple[int, int, int]

_FONT = cv2.FONT_HERSHEY_SIMPLEX
_SCALE = 0.5


def write(
    tile: Bytes,
    text: str,
    at: tuple[int, int],
    colour: Colour,
    *,
    align: Literal["left", "right"] = "left",
    ground: Colour | None = None,
) -> None:
    """Write ASCII ``text`` with its baseline's left or right end at ``at`` (x, y), on a box of ``ground``'s colour."""
    x, y = at
    (width, height), below = cv2.getTextSize(text, _FONT, _SCALE, 1)
    if align == "right":
        x -= width
    if ground is not None:
        cv2.rectangle(tile, (x - 3, y - height - 3), (x + width + 2, y + below), ground, -1)
    cv2.putText(tile, text, (x, y), _FONT, _SCALE, colour, 1, cv2.LINE_AA)
