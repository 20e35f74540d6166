"""A stage that lets the teacher, the policy or chance drive by turns, so that the teacher is asked everywhere."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphnav import Latest, Role, Stage, Stamp, State, Twist, hookimpl, param

TEACHER, POLICY, CHANCE = range(3)
_NONE_YET = Latest[Twist]()


class Mix(Stage):
    """Commands of the teacher, of the policy, or at random, for a drawn while each.

    Near an obstacle the teacher drives for a while, so that a drive goes on and shows how one gets away from it. The
    longer a drive lasts, the more places it shows that the teacher alone would not come to [DAgger].

    References
    ----------
    .. [DAgger] S. Ross, G. Gordon, J. A. Bagnell, A Reduction of Imitation Learning and Structured Prediction to
       No-Regret Online Learning, AISTATS 2011.
    """

    role: ClassVar[Role] = "oracle"

    policy_ratio: float = param(0.0, ge=0.0, le=1.0, doc="share of the turns that the policy gets")
    chance_ratio: float = param(
        0.25, ge=0.0, le=1.0, doc="share of the turns that chance gets; the teacher has the rest"
    )
    turn_s: float = param(1.5, gt=0.0, le=60.0, doc="mean length of a turn; those of chance are half as long")
    near_m: float = param(0.08, ge=0.0, le=10.0, doc="clearance below which the teacher takes over")
    rescue_s: float = param(1.5, gt=0.0, le=60.0, doc="for how long it then drives")
    max_speed_mps: float = param(0.3, gt=0.0, le=20.0, doc="fastest that chance drives")
    max_turn_radps: float = param(1.2, gt=0.0, le=20.0, doc="fastest that chance turns")

    def reset(self, seed: int) -> None:
        """Begin with the teacher."""
        self._rng = np.random.default_rng([seed, 77])
        self._driver, self._until = TEACHER, 0
        self._chance = Twist(v_mps=0.0, omega_radps=0.0)

    def step(self, teacher: Twist, state: State, stamp: Stamp, policy: Latest[Twist] = _NONE_YET) -> Twist:
        """Return the command of who drives now."""
        if state.clearance_m < self.near_m and self._driver != TEACHER:
            self._driver, self._until = TEACHER, stamp + int(self.rescue_s * 1e6)
        elif stamp >= self._until:
            self._draw(stamp)
        if self._driver == POLICY and policy.value is not None:
            return policy.value
        return self._chance if self._driver == CHANCE else teacher

    def _draw(self, stamp: int) -> None:
        drawn, length_s = self._rng.random(), self.turn_s * self._rng.uniform(0.3, 1.7)
        self._driver = POLICY if drawn < self.policy_ratio else TEACHER
        if drawn >= 1.0 - self.chance_ratio:
            self._driver, length_s = CHANCE, length_s / 2
            speed, turn = self._rng.uniform(0.3, 1.0), self._rng.uniform(-1.0, 1.0)
            self._chance = Twist(v_mps=self.max_speed_mps * speed, omega_radps=self.max_turn_radps * turn)
        self._until = stamp + int(length_s * 1e6)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stage."""
    return [Mix]
