"""Common to the programs that are compared: pictures with stamp and number, their pacing, and what has arrived.

It needs numpy alone: the programs run where graphnav is not installed. ``python -m peers.NAME FOLDER ROLE`` takes the
job from ``FOLDER/job.json``; its roles are ``hear`` and ``send``, or ``both`` where the library starts the processes
itself. They leave ``FOLDER/sent.json`` and ``FOLDER/heard.json``.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.uint8]

WARM_UP, PACED, FLOOD, END = range(4)
"""The parts of a job: not counted; at a rate, for the hop; as fast as it goes, for the throughput; no more follows."""
_HEAD = 3
"""int64 at the beginning of a picture: monotonic time in ns, part, number within its part."""
_HEAD_BYTES = 8 * _HEAD
_PAUSE_S = 0.3
_PATIENCE_S = 8.0


@dataclass(frozen=True)
class Job:
    """The pictures to send; ``large``: with the large buffers of the library; ``number``: free for names and ports."""

    rows: int
    cols: int
    rate_hz: float
    n_warm_up: int
    n_paced: int
    flood_s: float
    large: bool
    number: int

    @classmethod
    def read(cls, folder: Path) -> Job:
        """Return that of a folder."""
        return cls(**json.loads((folder / "job.json").read_text()))

    def write(self, folder: Path) -> None:
        """Write it into a folder."""
        (folder / "job.json").write_text(json.dumps(asdict(self)))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.rows, self.cols

    @property
    def n_bytes(self) -> int:
        """The size of a picture."""
        return self.rows * self.cols

    @property
    def max_s(self) -> float:
        """The time after which a listener that has heard no end gives up."""
        return (self.n_warm_up + self.n_paced) / self.rate_hz + self.flood_s + 3 * _PAUSE_S + _PATIENCE_S


def picture(shape: tuple[int, int], part: int, number: int) -> Pixels:
    """Return a picture, (rows, cols), with the time of now in its first pixels."""
    pixels = np.full(shape, 100, np.uint8)
    pixels.reshape(-1)[8:_HEAD_BYTES].view(np.int64)[:] = part, number
    stamp(pixels)
    return pixels


def stamp(pixels: Pixels) -> None:
    """Set the time in a picture, (rows, cols), to now."""
    pixels.reshape(-1)[:8].view(np.int64)[0] = time.monotonic_ns()


def pictures(job: Job, folder: Path) -> Iterator[Pixels]:
    """Yield the pictures of a job in time, each to be sent at once; then note how many there were."""
    begin_s = time.monotonic()
    for k in range(job.n_warm_up + job.n_paced):
        time.sleep(max(0.0, begin_s + k / job.rate_hz - time.monotonic()))
        part = WARM_UP if k < job.n_warm_up else PACED
        yield picture(job.shape, part, k - (job.n_warm_up if part == PACED else 0))
    n_flood = 0
    if job.flood_s > 0:
        time.sleep(_PAUSE_S)
        end_s = time.monotonic() + job.flood_s
        while time.monotonic() < end_s:
            yield picture(job.shape, FLOOD, n_flood)
            n_flood += 1
    (folder / "sent.json").write_text(json.dumps({"paced": job.n_paced, "flood": n_flood}))
    for _ in range(2):
        time.sleep(_PAUSE_S)
        yield picture(job.shape, END, 0)


class Listener:
    """Counts what arrives and notes it in ``folder`` at the end."""

    def __init__(self, job: Job, folder: Path) -> None:
        self.is_over = False
        self._folder, self._end_s = folder, time.monotonic() + job.max_s
        self._hops_us: list[float] = []
        self._numbers: dict[int, list[int]] = {part: [] for part in range(4)}
        self._flood_ns: list[int] = []
        self._n_bytes = job.n_bytes

    def take(self, pixels: Pixels) -> None:
        """Count a picture, (rows, cols)."""
        now = time.monotonic_ns()
        stamp, part, number = pixels.reshape(-1)[:_HEAD_BYTES].view(np.int64).tolist()
        self._numbers[part].append(number)
        if part == PACED:
            self._hops_us.append((now - stamp) / 1e3)
        elif part == FLOOD:
            self._flood_ns.append(now)
        elif part == END:
            self.is_over = True

    @property
    def is_late(self) -> bool:
        """Whether nothing more has to be awaited."""
        return self.is_over or time.monotonic() > self._end_s

    def finish(self) -> None:
        """Write what has arrived."""
        flood = self._flood_ns
        span_s = (flood[-1] - flood[0]) / 1e9 if len(flood) > 1 else 0.0
        found: dict[str, Any] = {
            "hops_us": self._hops_us,
            "paced": len(set(self._numbers[PACED])),
            "flood": len(set(self._numbers[FLOOD])),
            "out_of_order": sum(
                after < before for numbers in self._numbers.values() for before, after in pairwise(numbers)
            ),
            "flood_mb_s": self._n_bytes * (len(flood) - 1) / span_s / 1e6 if span_s else 0.0,
        }
        (self._folder / "heard.json").write_text(json.dumps(found))


def ready(folder: Path) -> None:
    """Tell that the listener listens."""
    (folder / "ready").touch()


def await_ready(folder: Path, settle_s: float = 0.5) -> None:
    """Wait for the listener, and until connections between the two are made."""
    end_s = time.monotonic() + 60
    while not (folder / "ready").exists() and time.monotonic() < end_s:
        time.sleep(0.02)
    time.sleep(settle_s)


Act = Callable[[Job, Path], None]


def main(**roles: Act) -> None:
    """Play the role of the command line."""
    folder, role = Path(sys.argv[1]), sys.argv[2]
    roles[role](Job.read(folder), folder)
