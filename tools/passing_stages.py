"""Stages that only pass a message on: what a tick costs without work."""

from __future__ import annotations

from graphnav import Source, Stage, Twist, hookimpl

FAMILY = "passing"


class Start(Source):
    """Publishes a command."""

    def step(self) -> Twist:
        """Return a command that drives."""
        return Twist(v_mps=0.1, omega_radps=0.0)


class Pass(Stage):
    """Publishes what it gets."""

    def step(self, twist: Twist) -> Twist:
        """Return the command."""
        return twist


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return them."""
    return [Start, Pass]
