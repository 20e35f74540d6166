"""Stages for the tests of replays: every way to read and to publish, deterministic and with memory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from graphnav import (
    Finished,
    Goal,
    Image,
    Latest,
    Metric,
    Motion,
    Since,
    Source,
    Stage,
    Stamp,
    Stamped,
    Twist,
    hookimpl,
    param,
)

FAMILY = "again"


class Sensed(NamedTuple):
    """The output of `Robot`."""

    image: Image
    odometry: Stamped[Motion] | None
    goal: Goal | None


class Robot(Source):
    """Publishes noise that depends on the command, motions with stamps of their own, and a goal now and then."""

    rows: int = param(4, ge=1, doc="height of the picture")
    last: int = param(-1, doc="ends the run with this firing; -1 never")

    def reset(self, seed: int) -> None:
        """Draw from the seed."""
        self._rng = np.random.default_rng(seed)
        self._count = 0

    def step(self, command: Latest[Twist], utime: Stamp) -> Sensed:
        """Publish what is due."""
        count, self._count = self._count, self._count + 1
        speed = command.value.v_mps if command.value else 0.0
        pixels = self._rng.integers(0, 200, (self.rows, 6), dtype=np.uint8) + np.uint8(min(50, abs(speed)))
        motion = Motion(forward_m=float(count), left_m=speed, turn_rad=0.0, interval_us=100)
        out = Sensed(
            image=Image(pixels=pixels),
            odometry=Stamped(motion, max(0, utime - 30_000)) if count else None,
            goal=Goal(bearing_rad=speed, distance_m=float(count)) if count % 3 == 0 else None,
        )
        if count == self.last:
            raise Finished("goal", out)
        return out


class Seen(NamedTuple):
    """The output of `World`."""

    image: Image | None
    noise: Stamped[Motion] | None
    truth: Image | None


class World(Source):
    """Moves by commands; publishes a large truth, which it makes again, only with the images that are due."""

    reproducible: ClassVar = ("truth",)

    image_steps: int = param(1, ge=1, doc="steps from one picture to the next")

    def reset(self, seed: int) -> None:
        """Draw from the seed."""
        self._rng = np.random.default_rng(seed)
        self._count, self._at = 0, 0.0

    def step(self, command: Latest[Twist], utime: Stamp) -> Seen:
        """Publish what is due."""
        count, self._count = self._count, self._count + 1
        self._at += command.value.v_mps * (1 + command.age_s) if command.value else 0.1
        noise = Motion(forward_m=self._rng.random(), left_m=self._at, turn_rad=0.0, interval_us=1)
        image = truth = None
        if count % self.image_steps == 0:
            image = Image(pixels=np.full((4, 6), int(abs(self._at)) % 200, np.uint8))
            truth = Image(pixels=self._rng.integers(0, 200, (80, 80), dtype=np.uint8) ^ image.pixels[0, 0])
        return Seen(image, Stamped(noise, max(0, utime - 3_000)) if count % 2 else None, truth)


class Watch(Stage):
    """Samples a picture."""

    def step(self, twist: Twist, image: Latest[Image]) -> Twist:
        """Return its mean."""
        mean = float(image.value.pixels.mean()) if image.value else -1.0
        return Twist(v_mps=twist.v_mps + mean, omega_radps=image.age_s)


class Brighten(Stage):
    """Publishes a large picture."""

    def step(self, image: Image) -> Image:
        """Return the picture, larger."""
        rows, cols = image.pixels.shape
        return Image(pixels=np.tile(image.pixels, (-(-80 // rows), -(-80 // cols))))


class Mean(Stage):
    """The mean gray level with memory: a replay that begins later has another one."""

    gain: float = param(0.5, doc="weight of the newest picture")
    offset: float = param(0.0, doc="dimensionless: is added from `since` on", renamed_from="shift")
    since: int = param(0, doc="the first step that is changed")

    def reset(self, seed: int) -> None:
        """Begin with a mean that the seed gives."""
        self._mean = float(np.random.default_rng(seed).random())
        self._steps = 0

    def step(self, image: Image) -> Twist:
        """Return the mean as a speed."""
        self._mean += self.gain * (float(image.pixels.mean()) - self._mean)
        self._steps += 1
        offset = self.offset if self._steps > self.since else 0.0
        return Twist(v_mps=self._mean + offset, omega_radps=float(self._steps))


class Gather(Stage):
    """Reads in all three ways."""

    def reset(self, seed: int) -> None:
        """Reset the count."""
        self._total = 0.0
        self._steps = 0

    def step(self, twist: Twist, odometry: Since[Motion], goal: Latest[Goal]) -> Twist | None:
        """Return sums; nothing at every fourth step."""
        self._total += sum(motion.forward_m + utime / 1e6 for utime, motion in odometry.messages)
        self._steps += 1
        if self._steps % 4 == 0:
            return None
        where = goal.value.distance_m + goal.age_s if goal.value else -1.0
        return Twist(v_mps=twist.v_mps + where, omega_radps=self._total)


class LateOutputs(NamedTuple):
    """The output of `Late`."""

    motion: Stamped[Motion]


class Late(Stage):
    """Publishes with a stamp of its own, half a period late."""

    def step(self, twist: Twist, utime: Stamp) -> LateOutputs:
        """Return a motion."""
        motion = Motion(forward_m=twist.v_mps, left_m=0.0, turn_rad=0.0, interval_us=1)
        return LateOutputs(Stamped(motion, max(0, utime - 50_000)))


class Score(Stage):
    """Adds speeds up."""

    metrics: ClassVar = (Metric("sum_mps", unit="m/s", better="higher", help="The sum."),)

    def reset(self, seed: int) -> None:
        """Begin with nothing."""
        self._sum = 0.0

    def step(self, twist: Twist) -> None:
        """Count one."""
        self._sum += twist.v_mps

    def summary(self) -> Mapping[str, float]:
        """Return the sum."""
        return {"sum_mps": self._sum}


class Spared(NamedTuple):
    """The output of `Spare`."""

    twist: Twist
    extra: Twist | None


class Spare(Source):
    """Publishes an output only where it is read."""

    def step(self) -> Spared:
        """Publish."""
        twist = Twist(v_mps=1.0, omega_radps=0.0)
        return Spared(twist, twist if self.is_read("extra") else None)


class SpareStep(Stage):
    """As `Spare`, but it steps in a replay."""

    def step(self, twist: Twist) -> Spared:
        """Publish."""
        return Spared(twist, twist if self.is_read("extra") else None)


class Fails(Stage):
    """Passes twists on and fails at one of them."""

    at: int = param(5, doc="the step that fails; -1 never")

    def reset(self, seed: int) -> None:
        """Reset the count."""
        self._steps = 0

    def step(self, twist: Twist) -> Twist:
        """Return the same."""
        self._steps += 1
        if self._steps == self.at:
            raise ValueError("worn out")
        return twist


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return them all."""
    return [Robot, World, Watch, Brighten, Mean, Gather, Late, Score, Spare, SpareStep, Fails]
