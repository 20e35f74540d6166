"""A stage with a constant, of which a changed copy is to be found by a replay."""

from __future__ import annotations

from graphnav import Stage, Twist, hookimpl

FAMILY = "limit"
MAX_LEFT_RADPS = 1.2


class Turn(Stage):
    """Limits turns to the left."""

    def step(self, command: Twist) -> Twist:
        """Return the command, turned no faster than allowed."""
        return Twist(v_mps=command.v_mps, omega_radps=min(command.omega_radps, MAX_LEFT_RADPS))


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages."""
    return [Turn]
