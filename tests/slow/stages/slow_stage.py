"""A stage that takes its time, for graphs that are to be late."""

from __future__ import annotations

import time

from graphnav import Image, Stage, hookimpl, param

FAMILY = "late"


class Slow(Stage):
    """Passes an image on after ``busy_ms``."""

    busy_ms: float = param(0.0, ge=0.0, doc="how long each step takes, milliseconds")

    def step(self, image: Image) -> Image:
        """Return the same image, later."""
        time.sleep(self.busy_ms / 1e3)
        return image


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages."""
    return [Slow]
