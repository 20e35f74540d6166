"""Stages for the tests of tuning: aims whose best parameters are known, a score that measures how near they are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, Literal

from graphnav import Finished, Metric, ParamError, Source, Stage, Twist, hookimpl, param

FAMILY = "aim"


class Clock(Source):
    """Ticks once; the seed is in what it publishes."""

    def reset(self, seed: int) -> None:
        self._offset = (seed % 7) / 70

    def step(self) -> Twist:
        raise Finished("goal", Twist(v_mps=self._offset, omega_radps=0.0))


class Near(Stage):
    """Best at a gain of 3, and a little better with the fine mode; its defaults are far off."""

    gain: float = param(1.0, gt=0.0, le=100.0, doc="dimensionless: the nearer to 3 the better")
    mode: Literal["coarse", "fine"] = param("coarse", doc="fine is better by 0.01")
    steps: int = param(2, ge=1, doc="changes nothing")
    free: float = param(0.0, doc="dimensionless: changes nothing, and nothing says what it could be")
    far: float | None = param(None, gt=0.0, doc="dimensionless: changes nothing")
    note: Path | None = param(None, doc="a file with what is added to the error")

    def check(self) -> None:
        if self.gain > 3.9:
            raise ParamError("gain", f"'gain' is {self.gain:g}: too much of it", "use less")

    def reset(self, seed: int) -> None:
        pass

    def step(self, twist: Twist) -> Twist:
        error = abs(self.gain - 3.0) - (0.01 if self.mode == "fine" else 0.0)
        error += float(self.note.read_text()) if self.note else 0.0
        return Twist(v_mps=error + twist.v_mps, omega_radps=0.0)


class Fixed(Stage):
    """As good as it is: better than `Near` with its defaults, worse than `Near` when that is tuned."""

    def reset(self, seed: int) -> None:
        pass

    def step(self, twist: Twist) -> Twist:
        return Twist(v_mps=1.0 + twist.v_mps, omega_radps=0.0)


class Frail(Near):
    """As `Near`; with a gain above 2 it fails, but in the worlds in which it is nearest."""

    def step(self, twist: Twist) -> Twist:
        if self.gain > 2.0 and twist.v_mps > 0.0:
            raise ValueError("out of range")
        return super().step(twist)


class Miss(Stage):
    """Scores the distance from the aim."""

    metrics: ClassVar = (
        Metric("miss_m", unit="m", better="lower", help="Distance from the aim."),
        Metric("hit", better="higher", if_failed=0.0, is_outcome=True, help="1 if it is near."),
    )

    note: Path | None = param(None, doc="a file with what is added to the miss")

    def reset(self, seed: int) -> None:
        self._miss_m = 0.0

    def step(self, twist: Twist) -> None:
        self._miss_m = twist.v_mps + (float(self.note.read_text()) if self.note else 0.0)

    def summary(self) -> Mapping[str, float]:
        return {"miss_m": self._miss_m, "hit": float(self._miss_m < 2.5)}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Clock, Near, Fixed, Frail, Miss]
