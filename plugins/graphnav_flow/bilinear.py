"""Sample images between their pixels, exactly bilinear (OpenCV rounds places to 1/32 pixel)."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles


def bilinear(values: Doubles, x: Doubles, y: Doubles) -> Doubles:
    """Return ``values`` (rows, cols, ...) at columns ``x`` and rows ``y``, both (m, n).

    Beyond the border the nearest pixel counts.
    """
    rows, cols = values.shape[:2]
    x, y = np.clip(x, 0, cols - 1), np.clip(y, 0, rows - 1)
    left, top = np.minimum(x.astype(np.intp), cols - 2), np.minimum(y.astype(np.intp), rows - 2)
    right_share, low_share = x - left, y - top
    lines = values.reshape(rows * cols, -1)
    first = top * cols + left
    sampled = np.zeros((*x.shape, lines.shape[1]))
    for offset, share in (
        (0, (1 - right_share) * (1 - low_share)),
        (1, right_share * (1 - low_share)),
        (cols, (1 - right_share) * low_share),
        (cols + 1, right_share * low_share),
    ):
        sampled += share[..., None] * lines[first + offset]
    return sampled.reshape(*x.shape, *values.shape[2:])
