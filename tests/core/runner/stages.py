"""Stages for the runner's tests: they count, pass on, join, fail."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from graphnav import Finished, Goal, Image, Latest, Metric, Source, Stage, Stamp, Twist, hookimpl, param

FAMILY = "probe"


class Counter(Source):
    """Publishes 0, 1, 2, … as a speed."""

    last: int = param(-1, doc="ends the run with this count; -1 never")
    every: int = param(1, ge=1, doc="publishes only every so many firings")

    def reset(self, seed: int) -> None:
        self._count = 0

    def step(self) -> Twist | None:
        value, self._count = self._count, self._count + 1
        out = Twist(v_mps=float(value), omega_radps=0.0) if value % self.every == 0 else None
        if value == self.last:
            raise Finished("goal", out)
        return out


class Dice(Source):
    """Publishes random numbers."""

    def reset(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)

    def step(self) -> Twist:
        return Twist(v_mps=float(self._rng.random()), omega_radps=0.0)


class Noise(Source):
    """Publishes random pictures."""

    rows: int = param(48, ge=1, doc="height of the picture")

    def reset(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)

    def step(self) -> Image:
        return Image(pixels=self._rng.integers(0, 255, (self.rows, 64), dtype=np.uint8))


class Plus(Stage):
    """Adds one."""

    def step(self, twist: Twist) -> Twist:
        return Twist(v_mps=twist.v_mps + 1, omega_radps=twist.omega_radps)


class Slow(Stage):
    """Takes its time."""

    step_ms: float = param(0.0, ge=0.0, doc="what a step takes at least")

    def step(self, twist: Twist) -> Twist:
        end_s = time.perf_counter() + self.step_ms / 1e3
        while (left_s := end_s - time.perf_counter()) > 0:
            time.sleep(left_s)
        return twist


class Two(NamedTuple):
    """Two ports, the second of which is often silent."""

    even: Twist
    odd: Twist | None


class Split(Stage):
    """Publishes on one port always, on the other for odd counts."""

    def step(self, twist: Twist) -> Two:
        return Two(twist, twist if twist.v_mps % 2 else None)


class Extra(NamedTuple):
    """Two ports, one of which is published where it is read."""

    twist: Twist
    extra: Twist | None


class Frugal(Stage):
    """Leaves out what nothing reads."""

    def step(self, twist: Twist) -> Extra:
        return Extra(twist, twist if self.is_read("extra") else None)


class Join(Stage):
    """Sums two inputs of one stamp."""

    metrics: ClassVar = (Metric("fired", better="neither", help="Firings."),)

    def reset(self, seed: int) -> None:
        self._fired: list[float] = []

    def step(self, a: Twist, b: Twist) -> Twist:
        self._fired.append(a.v_mps)
        return Twist(v_mps=a.v_mps + b.v_mps, omega_radps=0.0)

    def summary(self) -> Mapping[str, float]:
        return {"fired": len(self._fired)}


class Sampler(Source):
    """Publishes what it samples, and how old it is."""

    def step(self, command: Latest[Twist], stamp: Stamp) -> Twist:
        value = command.value.v_mps if command.value else -1.0
        return Twist(v_mps=value, omega_radps=command.age_s if math.isfinite(command.age_s) else float(stamp))


class Bad(Stage):
    """Does what a stage may not, from a count on."""

    what: str = param("raise", doc="raise, exit, type, shape, empty or hang")
    at: int = param(3, doc="the count at which it does it")

    def step(self, twist: Twist) -> Image:
        if twist.v_mps < self.at:
            return Image(pixels=np.zeros((2, 2), np.uint8))
        if self.what == "raise":
            raise KeyError("there is no such\nthing")
        if self.what == "exit":
            sys.exit(3)
        if self.what == "type":
            return Goal(bearing_rad=0.0, distance_m=1.0)  # type: ignore[return-value]
        if self.what == "shape":
            return Image(pixels=np.zeros((2, 2), np.complex128))
        if self.what == "empty":
            return Image(pixels=np.zeros((0, 2), np.uint8))
        print("hanging", file=sys.stderr, flush=True)
        while True:
            time.sleep(0.01)


class Look(Stage):
    """Reads pictures."""

    def step(self, image: Image) -> None:
        return None


class Nan(Stage):
    """Publishes what is not a number."""

    def step(self, twist: Twist) -> Twist:
        return Twist(v_mps=float("nan"), omega_radps=0.0)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Counter, Dice, Noise, Plus, Split, Frugal, Join, Sampler, Slow, Bad, Look, Nan]
