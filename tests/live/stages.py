"""Stages for the tests of live runs: they pass on, dawdle, remember what they were given, fail."""

from __future__ import annotations

import ctypes
import time
from typing import ClassVar

from graphnav import (
    Age,
    Finished,
    Goal,
    Image,
    Latest,
    Odometry,
    Since,
    Source,
    Stage,
    Stamp,
    Twist,
    hookimpl,
    param,
)

FAMILY = "probe"


class Brightness(Stage):
    """Publishes the mean gray level of an image as a speed."""

    dawdle_s: float = param(0.0, ge=0.0, doc="how long each step takes at least")
    fail_at: int = param(-1, doc="the step that raises; -1 for none")

    def reset(self, seed: int) -> None:
        self._count = 0

    def step(self, image: Image) -> Twist:
        self._count += 1
        if self._count == self.fail_at:
            raise ValueError("told to fail")
        time.sleep(self.dawdle_s)
        return Twist(v_mps=float(image.pixels.mean()), omega_radps=0.0)


class Trouble(Stage):
    """Publishes 1 m/s, until a picture of a certain gray level tells it to misbehave."""

    RAISE: ClassVar[int] = 201
    HANG: ClassVar[int] = 202
    HOLD_THE_GIL: ClassVar[int] = 203

    def step(self, image: Image) -> Twist:
        match int(image.pixels[0, 0]):
            case Trouble.RAISE:
                raise ValueError("told to fail")
            case Trouble.HANG:
                while True:
                    time.sleep(1)
            case Trouble.HOLD_THE_GIL:
                while True:
                    ctypes.PyDLL(None).usleep(900_000)
        return Twist(v_mps=1.0, omega_radps=0.0)


class Both(Stage):
    """Adds two speeds of one stamp."""

    def step(self, a: Twist, b: Twist) -> Twist:
        return Twist(v_mps=a.v_mps + b.v_mps, omega_radps=0.0)


class Pass(Stage):
    """Passes on; remembers nothing, so it may stand before motors."""

    is_guard = True

    def step(self, command: Twist | None, image: Latest[Image], age_s: Age) -> Twist:
        late = command is None or age_s > 0.3 or bool(image.fault)
        return Twist(v_mps=0.0 if command is None or late else command.v_mps, omega_radps=min(age_s, 1e3))


class Gather(Stage):
    """Publishes how many samples came since the last frame, and the newest one's stamp less the frame's."""

    def step(self, image: Image, odometry: Since[Odometry], utime: Stamp) -> Goal:
        stamps = [stamp for stamp, _ in odometry.messages]
        ahead_s = (max(stamps) - utime) * 1e-6 if stamps else -1.0
        return Goal(bearing_rad=float(len(stamps)), distance_m=ahead_s)


class Ticker(Source):
    """Publishes how old the newest command is; ends after ``last`` firings."""

    last: int = param(-1, doc="ends the run with this count; -1 never")

    def reset(self, seed: int) -> None:
        self._count = 0

    def step(self, command: Latest[Twist]) -> Goal:
        self._count += 1
        out = Goal(bearing_rad=float(self._count), distance_m=min(command.age_s, 1e3))
        if self._count == self.last:
            raise Finished("goal", out)
        return out


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Brightness, Trouble, Both, Pass, Gather, Ticker]
