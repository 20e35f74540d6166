"""A one-file plugin whose stages raise, do not return, end the process, or report what they did not declare."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from graphnav import Metric, Source, Stage, Twist, hookimpl, param

FAMILY = "odd"


class Escape(BaseException):
    """Derived from BaseException alone."""


class Unspeakable(Exception):  # noqa: N818
    """Cannot be converted to a string."""

    def __str__(self) -> str:
        raise ZeroDivisionError("in __str__")


KINDS: dict[str, BaseException] = {
    "exit_0": SystemExit(0),
    "exit_silently": SystemExit(),
    "ctrl_c": KeyboardInterrupt(),
    "stop_iteration": StopIteration(),
    "escape": Escape("from the framework"),
    "unspeakable": Unspeakable(),
    "long": ValueError("x" * 1_000_000),
    "lines": RuntimeError("two\nlines"),
}
ENDINGS: dict[str, Callable[[], object]] = {
    "exit": lambda: os._exit(0),
    "fault": lambda: os.kill(os.getpid(), signal.SIGSEGV),
}
OTHERS: dict[str, Callable[[], object]] = {
    "hang": lambda: threading.Event().wait(),
    "move": lambda: os.chdir("/"),
    "thread": lambda: threading.Thread(target=threading.Event().wait, name="lost\x1b[2J").start(),
}
SUMMARIES: dict[str, Any] = {
    "undeclared": dict.fromkeys(map(str, range(1000)), 1.0),
    "number_key": {1: 1.0},
    "huge": {"steps": 10**400},
    "none": {"steps": None},
    "list": [1.0],
}


def misbehave(kind: str) -> None:
    """Raise an exception of a kind, or do what concerns the entire process."""
    if kind in KINDS:
        raise KINDS[kind]
    (ENDINGS | OTHERS)[kind]()


class Clock(Source):
    """Publishes a speed; may misbehave where a source is asked when it is due."""

    kind: str = param("", doc="how it misbehaves")

    def due_us(self, firing: int) -> int:
        if self.kind == "never_later":
            return 0
        if self.kind and firing == 3:
            misbehave(self.kind)
        return super().due_us(firing)

    def step(self) -> Twist:
        return Twist(v_mps=1.0, omega_radps=0.0)


class Faulty(Stage):
    """Misbehaves in one method: in the third step, if it is that."""

    kind: str = param("", doc="how it misbehaves")
    method: str = param("", doc="where")
    metrics: ClassVar = (Metric("steps", better="neither", help="Number of steps."),)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._maybe("__init__")

    def check(self) -> None:
        self._maybe("check")

    def reset(self, seed: int) -> None:
        self._steps = 0
        self._maybe("reset")

    def step(self, twist: Twist) -> Twist:
        self._steps += 1
        if self._steps == 3:
            self._maybe("step")
        return twist

    def summary(self) -> Mapping[str, float]:
        self._maybe("summary")
        return {"steps": self._steps}

    def close(self) -> None:
        self._maybe("close")

    def _maybe(self, method: str) -> None:
        if self.method == method:
            misbehave(self.kind)


class Liar(Stage):
    """Reports what it may not."""

    kind: str = param("", doc="what it reports")
    metrics: ClassVar = (Metric("steps", better="neither", help="Number of steps."),)

    def step(self, twist: Twist) -> None:
        pass

    def summary(self) -> Mapping[str, float]:
        return SUMMARIES[self.kind]  # type: ignore[no-any-return]


class Meddler(Stage):
    """Changes what it is given."""

    def step(self, twist: Twist) -> None:
        twist.__dict__["v_mps"] = 7.0
        del twist.__dict__["omega_radps"]


class Speed(Stage):
    """Reports the fastest speed of its input."""

    metrics: ClassVar = (Metric("speed", better="neither", help="Fastest."),)

    def reset(self, seed: int) -> None:
        self._fastest = 0.0

    def step(self, twist: Twist) -> None:
        self._fastest = max(self._fastest, twist.v_mps + twist.omega_radps)

    def summary(self) -> Mapping[str, float]:
        return {"speed": self._fastest}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Clock, Faulty, Liar, Meddler, Speed]
