"""Play frames, one per firing, and end the run with the last one."""

from __future__ import annotations

from graphnav import Finished, Image
from graphnav_io.frames import Frames
from graphnav_io.preparation import Preparation


def next_image(frames: Frames, preparation: Preparation) -> Image:
    """Return the next frame as a message.

    Raises
    ------
    Finished
        It is the last frame, which the exception carries, or there is none left.
    ValueError
        The frame cannot be decoded or has another size.
    """
    pixels = frames.read()
    if pixels is None:
        raise Finished("end")
    image = Image(pixels=preparation.apply(pixels))
    if frames.at_end:
        raise Finished("end", image)
    return image
