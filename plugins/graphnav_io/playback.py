"""Plays frames, one a firing, and ends the run with the last one."""

from __future__ import annotations

from graphnav import Finished, Image
from graphnav_io.frames import Frames
from graphnav_io.shape import Shape


def next_image(frames: Frames, shape: Shape) -> Image:
    """Return the next frame as a message.

    Raises
    ------
    Finished
        It is the last one, which comes with it, or there is none left.
    ValueError
        It cannot be decoded or has another size.
    """
    pixels = frames.read()
    if pixels is None:
        raise Finished("end")
    image = Image(pixels=shape.apply(pixels))
    if frames.at_end:
        raise Finished("end", image)
    return image
