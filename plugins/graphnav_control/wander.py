"""Drive at random, to cover many motions."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Continuity, Image, Stage, Stamp, Twist, param


class Wander(Stage):
    """Smooth random driving over free ground, for teaching.

    Draws a new speed and a new turning rate, uniformly and independently, at random times, and approaches them
    exponentially; some of the legs drive straight on. Ignores the image: it needs a world without obstacles.
    """

    max_speed_mps: float = param(0.4, gt=0.0, le=1000.0, doc="maximum forward speed; the minimum is 0")
    max_turn_radps: float = param(1.6, gt=0.0, le=1000.0, doc="maximum turning rate, to either side")
    leg_s: float = param(
        1.0, gt=0.0, le=1e6, doc="mean time between two draws; more covers fewer motions in the same time"
    )
    response_s: float = param(0.3, ge=0.0, le=1e6, doc="time constant of approaching a draw; 0 jumps")
    straight_ratio: float = param(0.25, ge=0.0, le=1.0, doc="share of the legs that drive straight on")

    def reset(self, seed: int) -> None:
        """Start at rest."""
        self._rng = np.random.default_rng(seed)
        self._twist = self._wanted = np.zeros(2)
        self._next_us = self._last_us = 0
        self._continuity = Continuity()

    def step(self, image: Image, now: Stamp) -> Twist:  # noqa: ARG002  # the image only tells that a frame passed
        """Return the command of this frame; after a gap of more than 3 periods it starts at rest again."""
        if self._continuity.breaks(now):
            self._twist = np.zeros(2)
            self._next_us = self._last_us = now
        if now >= self._next_us:
            straight = self._rng.random() < self.straight_ratio
            turn_radps = 0.0 if straight else self._rng.uniform(-self.max_turn_radps, self.max_turn_radps)
            self._wanted = np.array([self._rng.uniform(0.0, self.max_speed_mps), turn_radps])
            self._next_us = now + round(1e6 * self._rng.exponential(self.leg_s))
        elapsed_s = (now - self._last_us) / 1e6
        near = 1.0 - math.exp(-elapsed_s / self.response_s) if self.response_s else 1.0
        self._twist = self._twist + near * (self._wanted - self._twist)
        self._last_us = now
        return Twist(v_mps=float(self._twist[0]), omega_radps=float(self._twist[1]))
