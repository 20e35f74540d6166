"""Stages that count, fail, print, end their process, or start others, for graphs whose stages live in processes."""

import contextlib
import os
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, NamedTuple

from graphnav import Finished, Latest, Metric, Since, Source, Stage, Stamp, Stamped, Twist, hookimpl, param

FAMILY = "steps"


def counted(value: float) -> Twist:
    return Twist(v_mps=value, omega_radps=0.0)


class Count(Source):
    """Counts its firings, adds the newest that it hears, and ends the run after ``n``."""

    n: int = param(5, ge=1, doc="firings")
    every_us: int = param(0, ge=0, doc="if not 0, firings have irregular times, which grow by so many microseconds")

    def reset(self, seed: int) -> None:
        self._count = 0
        self._random = seed % 1000

    def step(self, heard: Latest[Twist]) -> Twist:
        self._count += 1
        value = heard.value.v_mps * 0.5 + heard.age_s if heard.value is not None else self._random
        if self._count == self.n:
            raise Finished("goal", counted(self._count + value))
        return counted(self._count + value)

    def due_us(self, firing: int) -> int:
        if self.every_us:
            return firing * self.every_us + firing * firing
        return super().due_us(firing)


class Sums(NamedTuple):
    """Outputs of `Add`."""

    sum: Twist
    late: Stamped[Twist] | None


class Add(Stage):
    """Adds what it reads, with what came since its last step; a message in two has a stamp of its own."""

    takes_ms: float = param(0.0, ge=0.0, doc="time that a step takes")
    metrics: ClassVar[tuple[Metric, ...]] = (Metric("steps", help="How many steps it made.", better="neither"),)

    def reset(self, seed: int) -> None:
        self._sum = float(seed % 7)
        self._n = 0

    def step(self, one: Twist, old: Latest[Twist], others: Since[Twist], stamp: Stamp) -> Sums:
        time.sleep(self.takes_ms / 1e3)
        self._n += 1
        self._sum += one.v_mps + sum(m.v_mps + utime * 1e-6 for utime, m in others.messages)
        self._sum += old.value.v_mps * 1e-3 if old.value is not None else 0.25 * old.is_connected
        late = Stamped(counted(self._n), stamp - 7) if self._n % 2 else None
        return Sums(counted(self._sum), late)

    def summary(self) -> Mapping[str, float]:
        return {"steps": self._n}


class Both(Stage):
    """Adds two messages of one stamp."""

    def step(self, one: Twist, two: Twist) -> Twist:
        return counted(one.v_mps + two.v_mps)


class Pass(Stage):
    """Publishes what it reads, until ``what`` happens at a step."""

    at: int = param(0, ge=0, doc="the step at which it happens, 0 for the reset")
    what: str = param("nothing", doc="what happens then")
    file: str = param("", doc="a file that it writes")
    other: str = param("", doc="a file that it waits for")

    def reset(self, seed: int) -> None:
        self._n = 0
        if self.at == 0:
            self._happens()

    def step(self, one: Twist) -> Twist:
        self._n += 1
        if self._n == self.at:
            self._happens()
        value = float("nan") if self.what == "nan" and self._n == self.at else one.v_mps
        return counted(value + self._noise() if self.what == "random" else value)

    def close(self) -> None:
        if self.what == "close":
            raise ValueError("it does not close")

    def _noise(self) -> float:
        return int.from_bytes(os.urandom(2)) + 0.5

    def _happens(self) -> None:
        if self.what == "fail":
            raise ValueError("it fails")
        if self.what == "exit":
            os._exit(3)
        if self.what == "once" and not Path(self.file).exists():
            Path(self.file).touch()
            os._exit(0)
        if self.what == "meet":
            Path(self.file).touch()
            while not Path(self.other).exists():
                time.sleep(0.001)
        if self.what == "print":
            print(f"step {self._n}\x1b[2J")
        if self.what == "hang":
            Path(self.file).write_text(str(os.getpid()))
            time.sleep(600)
        if self.what == "shut":
            for name in os.listdir("/proc/self/fd"):
                with contextlib.suppress(OSError), socket.socket(fileno=os.dup(int(name))) as found:
                    found.shutdown(socket.SHUT_RDWR)
            time.sleep(600)
        if self.what == "start":
            command = [sys.executable, "-c", "import time; time.sleep(600)"]
            started = [subprocess.Popen(command, start_new_session=is_apart) for is_apart in (False, True)]
            Path(self.file).write_text(" ".join(str(one.pid) for one in started))


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Count, Add, Both, Pass]
