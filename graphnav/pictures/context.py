"""What a picture of one message is drawn with: the size asked for, and other messages of the same moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from graphnav.arrays import Doubles
from graphnav.messages import Message

M = TypeVar("M", bound=Message)


class Find(Protocol):
    """Finds the message of another type that belongs to the one that is drawn."""

    def __call__(self, kind: type[M], /) -> M | None:
        """Return the message of ``kind`` of the same stamp, else the newest before it; None if there is none."""


def no_message(_kind: type[M], /) -> M | None:
    """Find nothing: only the message itself is known."""
    return None


def no_path() -> Doubles:
    """Return a path without points."""
    return np.empty((0, 2))


@dataclass(frozen=True)
class PictureContext:
    """What the caller of ``graphnav_picture`` gives beside the message.

    ``rows``, ``cols``: the box, in pixels, that the picture has to fit into. ``find``: other messages of the moment, as
    the image below a plane or the map around a state; it decodes only what is asked for. ``path_m``: returns where the
    robot was so far, float64 (n, 2), x_m and y_m in W, oldest first. ``with_legend``: whether there is room for
    letters, scale bars and colour wheels. ``with_colour``: whether colours are seen; where not, only brightness tells.
    """

    rows: int = 480
    cols: int = 640
    find: Find = no_message
    path_m: Callable[[], Doubles] = no_path
    with_legend: bool = True
    with_colour: bool = True
