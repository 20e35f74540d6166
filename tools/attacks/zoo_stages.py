"""Stages each of whose methods misbehaves in every way."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

from graphnav import Metric, Source, Stage, Twist, hookimpl, param

FAMILY = "zoo"


class Escape(BaseException):
    """Derived from BaseException alone."""


class Unspeakable(Exception):  # noqa: N818
    """Cannot be converted to a string."""

    def __str__(self) -> str:
        raise ZeroDivisionError("in __str__")

    __repr__ = __str__


class Mute(Exception):  # noqa: N818
    """Its message is not a string."""

    def __str__(self) -> str:
        return 3  # type: ignore[return-value]  # noqa: PLE0307 - that is the point


KINDS: dict[str, BaseException] = {
    "exit_0": SystemExit(0),
    "exit_7": SystemExit(7),
    "exit_silently": SystemExit(),
    "ctrl_c": KeyboardInterrupt(),
    "generator_exit": GeneratorExit("done"),
    "stop_iteration": StopIteration(),
    "escape": Escape("from the framework"),
    "unspeakable": Unspeakable(),
    "mute": Mute(),
    "unspeakable_exit": type("UnspeakableExit", (SystemExit,), {"__str__": Unspeakable.__str__})(),
    "long": ValueError("x" * 1_000_000),
    "lines": RuntimeError("two\nlines"),
}


def misbehave(kind: str) -> None:
    """Raise an exception of a kind, or do what concerns the entire process."""
    if kind in KINDS:
        raise KINDS[kind]
    (INTRUSIONS | ENDINGS)[kind]()


def misbehaving_twist(kind: str) -> Twist:
    """Return a message each of whose attributes raises."""
    return object.__new__(type("Sly", (Twist,), {"__getattribute__": lambda *_: misbehave(kind)}))


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


class Animal(Stage):
    """Misbehaves in one method."""

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
            if self.method == "outputs":
                return misbehaving_twist(self.kind)
        return twist

    def summary(self) -> Mapping[str, float]:
        self._maybe("summary")
        return {"steps": self._steps}

    def close(self) -> None:
        self._maybe("close")

    def _maybe(self, method: str) -> None:
        if self.method == method:
            misbehave(self.kind)


class Endless(Mapping[str, float]):
    """A mapping without an end."""

    def __getitem__(self, key: str) -> float:
        return 1.0

    def __len__(self) -> int:
        return 1

    def __iter__(self) -> Iterator[str]:
        while True:
            yield "steps"


class Shy:
    """Has no repr."""

    def __repr__(self) -> str:
        raise SystemExit(0)


SUMMARIES: dict[str, Any] = {
    "endless": Endless(),
    "undeclared": dict.fromkeys(map(str, range(1000)), 1.0),
    "number_key": {1: 1.0},
    "shy_key": {Shy(): 1.0},
    "shy_value": {"steps": Shy()},
    "huge": {"steps": 10**400},
    "none": {"steps": None},
    "list": [1.0],
}


class Liar(Stage):
    """Reports what it may not."""

    kind: str = param("", doc="what it reports")
    metrics: ClassVar = (Metric("steps", better="neither", help="Number of steps."),)

    def step(self, twist: Twist) -> None:
        pass

    def summary(self) -> Mapping[str, float]:
        return SUMMARIES[self.kind]  # type: ignore[no-any-return]


class Mover(Stage):
    """Changes the working folder."""

    method: str = param("step", doc="where")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.method == "__init__":
            os.chdir("/")

    def step(self, twist: Twist) -> None:
        os.chdir("/")


class Meddler(Stage):
    """Changes what it is given."""

    def step(self, twist: Twist) -> None:
        twist.__dict__["v_mps"] = 7.0
        del twist.__dict__["omega_radps"]


def _replace_streams() -> None:
    sys.stdout = sys.stderr = None


def _close_streams() -> None:
    sys.stdout.close()
    sys.stderr.close()


def _ignore_signals() -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)


INTRUSIONS: dict[str, Callable[[], object]] = {
    "fork": os.fork,
    "thread": lambda: threading.Thread(target=threading.Event().wait, name="lost\x1b[2J").start(),
    "replace_streams": _replace_streams,
    "close_streams": _close_streams,
    "ignore_signals": _ignore_signals,
}
ENDINGS: dict[str, Callable[[], object]] = {
    "exit": lambda: os._exit(0),
    "fault": lambda: os.kill(os.getpid(), signal.SIGSEGV),
}


class Speed(Stage):
    """Reports the fastest speed of its input."""

    metrics: ClassVar = (Metric("speed", better="neither", help="Fastest."),)

    def reset(self, seed: int) -> None:
        self._fastest = 0.0

    def step(self, twist: Twist) -> None:
        self._fastest = max(self._fastest, twist.v_mps + twist.omega_radps)

    def summary(self) -> Mapping[str, float]:
        return {"speed": self._fastest}


class Sleeper(Stage):
    """Does not return from one method."""

    method: str = param("step", doc="where")
    metrics: ClassVar = (Metric("steps", better="neither", help="Number of steps."),)

    def reset(self, seed: int) -> None:
        self._steps = 0
        self._maybe("reset")

    def step(self, twist: Twist) -> None:
        self._steps += 1
        if self._steps == 3:
            self._maybe("step")

    def summary(self) -> Mapping[str, float]:
        self._maybe("summary")
        return {}

    def close(self) -> None:
        self._maybe("close")

    def _maybe(self, method: str) -> None:
        if self.method == method:
            threading.Event().wait()


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Clock, Animal, Liar, Meddler, Mover, Sleeper, Speed]
