"""A camera of a few pixels and what reads it: the log of a short run of them is small enough to be cut everywhere."""

from __future__ import annotations

import numpy as np

from graphnav import Image, Source, Stage, Twist, hookimpl, param

FAMILY = "tiny"


class Camera(Source):
    """Publishes noise."""

    def reset(self, seed: int) -> None:
        """Draw from the seed."""
        self._rng = np.random.default_rng(seed)

    def step(self) -> Image:
        """Return the next picture."""
        return Image(pixels=self._rng.integers(0, 256, (6, 8), dtype=np.uint8))


class Mean(Stage):
    """Publishes the mean gray level of all pictures as a speed."""

    gain_ratio: float = param(0.5, ge=0.0, le=1.0, doc="weight of the newest picture")

    def reset(self, seed: int) -> None:
        """Begin with a gray level that is drawn."""
        self._mean = float(np.random.default_rng(seed).uniform(0, 255))

    def step(self, image: Image) -> Twist:
        """Return the mean."""
        self._mean += self.gain_ratio * (float(image.pixels.mean()) - self._mean)
        return Twist(v_mps=self._mean, omega_radps=0.0)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return them."""
    return [Camera, Mean]
