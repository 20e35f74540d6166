"""How steering counts cells that could not be judged."""

from __future__ import annotations

from typing import Literal

import numpy as np

from graphnav import Plane
from graphnav.arrays import Bytes

Unjudged = Literal["obstacle", "free"]

UNJUDGED_DOC = (
    "how a cell counts that was not judged although it lies inside the rim, as on a white wall without texture "
    "(`Plane.unknown`): as an obstacle, or as free floor; cells of the rim count as free"
)
RIM_DOC = (
    "width of the rim, a share of the picture's shorter side: there flow is not valid, so that cells that were "
    "not judged mean nothing; the faster the robot moves and turns between two frames, the wider"
)


def with_unjudged(plane: Plane, unjudged: Unjudged, rim_ratio: float) -> tuple[Bytes, Bytes]:
    """Return the obstacles to avoid and the cells that count, both uint8 (rows, cols)."""
    if unjudged == "free":
        return plane.obstacle, plane.valid
    unknown = plane.unknown(rim_ratio).view(np.uint8)
    return plane.obstacle | unknown, plane.valid | unknown
