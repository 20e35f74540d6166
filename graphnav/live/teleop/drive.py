"""Keys to a twist, with a dead man's timeout: a terminal reports key presses, but not releases."""

from __future__ import annotations

import math

from graphnav import Twist
from graphnav.live.teleop.keys import Key

ZERO_S = 0.3
"""How long zero is published after the keys are released; then nothing is sent, and an override goes stale."""
_STEP_RATIO = 1.1
_V = {Key.FORWARD: 1.0, Key.BACK: -1.0}
_OMEGA = {Key.LEFT: 1.0, Key.RIGHT: -1.0}


class Drive:
    """The command of the keys pressed in the last ``timeout_s``; forward and turn have separate timeouts.

    ``speed_mps``, ``turn_radps``: speeds while a key is pressed; Key.FASTER and Key.SLOWER change both by a tenth.
    """

    def __init__(self, speed_mps: float, turn_radps: float, timeout_s: float) -> None:
        self.speed_mps, self.turn_radps = speed_mps, turn_radps
        self._timeout_s = timeout_s
        self._v = self._omega = (0.0, -math.inf)
        self._zero_until_s = -math.inf
        self._is_driving = False

    def press(self, key: Key, now_s: float) -> None:
        """Handle a key pressed, or repeated, at ``now_s``."""
        if key in _V:
            self._v = _V[key], now_s
        elif key in _OMEGA:
            self._omega = _OMEGA[key], now_s
        elif key in {Key.HALT, Key.STOP}:
            self._v = self._omega = (0.0, -math.inf)
            self._zero_until_s = now_s + ZERO_S
        elif key is Key.FASTER:
            self._scale(_STEP_RATIO)
        elif key is Key.SLOWER:
            self._scale(1 / _STEP_RATIO)
        if key in _V or key in _OMEGA:
            self._zero_until_s = now_s + self._timeout_s + ZERO_S

    def command(self, now_s: float) -> Twist | None:
        """Return the command to publish now, None for none; after a speed there is a zero, however late it is."""
        v, omega = (sign if now_s - at_s <= self._timeout_s else 0.0 for sign, at_s in (self._v, self._omega))
        was_driving, self._is_driving = self._is_driving, bool(v or omega)
        if self._is_driving:
            return Twist(v_mps=v * self.speed_mps, omega_radps=omega * self.turn_radps)
        return Twist(v_mps=0.0, omega_radps=0.0) if was_driving or now_s <= self._zero_until_s else None

    def _scale(self, ratio: float) -> None:
        self.speed_mps *= ratio
        self.turn_radps *= ratio
