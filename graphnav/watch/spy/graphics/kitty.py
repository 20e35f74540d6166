"""Pictures by kitty's graphics protocol: pixels that the terminal scales to a rectangle of cells."""

from __future__ import annotations

import base64
import zlib

from graphnav.arrays import Bytes

_CHUNK = 4096
"""The protocol's limit for the characters of one sequence."""
_FAST = 1


def put(picture: Bytes, image_id: int, rows: int, cols: int) -> str:
    """Return the sequences that show a picture (rows, cols, 3) on ``rows`` x ``cols`` cells, from the cursor on.

    The cursor does not move, and the terminal does not answer. ``image_id``: 1 to 2**32 - 1; an existing image with
    this id is replaced.
    """
    data = base64.standard_b64encode(zlib.compress(picture.tobytes(), _FAST)).decode("ascii")
    height, width = picture.shape[:2]
    keys = f"a=T,q=2,C=1,f=24,o=z,s={width},v={height},i={image_id},p=1,c={cols},r={rows},"
    chunks = [data[at : at + _CHUNK] for at in range(0, len(data), _CHUNK)]
    last = len(chunks) - 1
    return "".join(
        f"\x1b_G{keys if place == 0 else ''}m={int(place < last)};{chunk}\x1b\\" for place, chunk in enumerate(chunks)
    )


def delete(image_id: int) -> str:
    """Return the sequence that deletes an image from the screen and from the terminal's memory."""
    return f"\x1b_Ga=d,d=I,q=2,i={image_id}\x1b\\"
