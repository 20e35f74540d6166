"""Stages for the tests of studies: a source that walks to its goal, or comes to grief; a score."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, Literal

from graphnav import Finished, Metric, Source, Stage, Twist, hookimpl, param

FAMILY = "toy"


class Walker(Source):
    """Walks for as many ticks as its seed says; with odd seeds something may happen at the second tick."""

    odd: Literal["fine", "contact", "raise", "exit", "kill", "hang"] = param("fine", doc="what happens with odd seeds")
    times: int = param(1, ge=1, doc="how much longer it walks")
    once: Path | None = param(None, doc="where it notes that it happened, so that it does not happen again")

    def reset(self, seed: int) -> None:
        self._k = 0
        self._last = (3 + seed % 5) * self.times
        self._is_odd = seed % 2 == 1
        if self._is_odd and self.odd == "contact":
            self._last = 2

    def step(self) -> Twist:
        self._k += 1
        if self._k == 2 and self._is_odd:
            self._come_to_grief()
        if self._k == self._last:
            raise Finished("contact" if self._is_odd and self.odd == "contact" else "goal", Twist(0.0, 0.0))
        return Twist(v_mps=float(self._k), omega_radps=0.0)

    def _come_to_grief(self) -> None:
        if self.once is not None:
            if self.once.exists():
                return
            self.once.touch()
        if self.odd == "raise":
            raise ValueError("worn out")
        if self.odd == "exit":
            os._exit(3)
        if self.odd == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.odd == "hang":
            threading.Event().wait()


class Unready(Stage):
    """Cannot be reset."""

    def reset(self, seed: int) -> None:
        raise RuntimeError("no model")

    def step(self, twist: Twist) -> None:
        pass


class Distance(Stage):
    """Scores how far it went."""

    metrics: ClassVar = (
        Metric("way_m", unit="m", better="higher", help="How far it went."),
        Metric("turn_rad", unit="rad", better="neither", help="How far it turned; left out, because it never does."),
    )

    def reset(self, seed: int) -> None:
        self._sum = 0.0

    def step(self, twist: Twist) -> None:
        self._sum += twist.v_mps

    def summary(self) -> Mapping[str, float]:
        return {"way_m": self._sum}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Walker, Unready, Distance]
