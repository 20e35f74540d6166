"""When enough is taught."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphnav.live.teaching.taught import Taught

NEAR_RATIO = 0.8
"""A motion of at least this share of a limit counts as near it."""
MIN_FRAMES = 10
"""Frames near each limit: fewer may be errors of the odometry."""
SETTLED_RATIO = 0.05
"""Largest change of the residual between two models that are alike."""


class Coverage(NamedTuple):
    """Motions to teach: speeds up to ``speed_mps``, turning rates up to ``turn_radps`` to each side."""

    speed_mps: float
    turn_radps: float

    def is_reached(self, taught: Taught) -> bool:
        """Whether the motions that the newest model was made of reach each limit, and it is like the one before it.

        At least 10 frames must be near a limit.
        """
        speeds, turns = taught.learnt_rates.T
        for values, limit in ((speeds, self.speed_mps), (turns, self.turn_radps), (-turns, self.turn_radps)):
            near = np.count_nonzero(values >= NEAR_RATIO * limit)
            if near < MIN_FRAMES or values.max() < limit:
                return False
        last = taught.residuals_px[-2:]
        return len(last) == 2 and abs(last[1] - last[0]) <= SETTLED_RATIO * last[0]
