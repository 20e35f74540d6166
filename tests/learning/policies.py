"""A one-file plugin with stages that drive: what an agent does as well."""

from __future__ import annotations

import math
from typing import NamedTuple

from graphnav import Image, Plane, Stage, Stamp, Twist, hookimpl, param


class Weave(Stage):
    """Drives on in waves, once an image has come."""

    def step(self, image: Image, stamp: Stamp) -> Twist:
        """Return the command of an image."""
        return Twist(0.2, 0.3 * math.sin(stamp * 1e-6) + 0.001 * float(image.pixels[0, 0]))


class Weaves(NamedTuple):
    """Outputs of `Half`."""

    twist: Twist


class Half(Stage):
    """Drives on in waves, at each plane."""

    fails_at_s: float = param(1e9, doc="when it fails")

    def step(self, plane: Plane, stamp: Stamp) -> Weaves:
        """Return the command of a plane."""
        if stamp * 1e-6 >= self.fails_at_s:
            raise ValueError("no way out")
        return Weaves(Twist(0.2, plane.obstacle_ratio))


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages."""
    return [Weave, Half]
