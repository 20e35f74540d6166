"""The firings of a live run by a clock that only steps and waiting let pass."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphnav import Image, Stage
from graphnav.core.catalog import Catalog
from graphnav.core.codec import decode, encode
from graphnav.core.errors import StageError
from graphnav.core.graph import load_graph
from graphnav.core.messages import Fired
from graphnav.live.clock import LiveClock
from graphnav.live.inputs.intake import Intake
from graphnav.live.live_schedule import LiveSchedule

STAGES = Path(__file__).parents[1] / "stages.py"
GRAPH = """
run: {until_s: 0.3}
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t, max_age_s: 1.0}}
stages:
  tick:  {use: probe.ticker, with: {rate_hz: 10}, in: {command: guard.twist}}
  see:   {use: probe.brightness, in: {image: camera.image}}
  slow:  {use: probe.brightness, in: {image: camera.image}, deadline_ms: 40}
  both:  {use: probe.both, in: {a: see.twist, b: slow.twist}}
  guard: {use: probe.pass, every_ms: 100, in: {command: both.twist, image: camera.image}}
"""
START_US = 1_700_000_000_000_000


class Clock:
    """Monotonic seconds, and what waits for them."""

    def __init__(self) -> None:
        self.now_s = 50.0

    def ms(self) -> int:
        """Return the milliseconds since the start."""
        return round((self.now_s - 50.0) * 1e3)


class Arrivals(threading.Event):
    """Puts pictures into a mailbox when their time has come; a wait lasts until the next one."""

    def __init__(self, clock: Clock, intake: Intake, at_ms: Sequence[int]) -> None:
        super().__init__()
        self._clock, self._intake = clock, intake
        self._pending = [(50.0 + ms / 1e3, number) for number, ms in enumerate(at_ms)]

    def look(self) -> bool:
        """Deliver what is due; the run goes on."""
        while self._pending and self._pending[0][0] <= self._clock.now_s:
            at_s, number = self._pending.pop(0)
            stamp = START_US + round((at_s - 50.0) * 1e6)
            self._intake.mailbox.put(encode(Image(pixels=np.full((2, 2), number, np.uint8)), stamp, number), at_s)
            self.set()
        return True

    def wait(self, timeout: float | None = None) -> bool:
        assert timeout is not None
        until_s = self._clock.now_s + timeout
        if self._pending:
            until_s = min(until_s, max(self._pending[0][0], self._clock.now_s))
        self._clock.now_s = until_s
        return self.look()


class Firings:
    """The log of a run, of which it keeps the firings."""

    def __init__(self) -> None:
        self.fired: list[tuple[str, int]] = []
        """Stage, and milliseconds since the start."""
        self.stamps_ms: dict[str, list[list[int]]] = {}
        """By stage, the stamps of the messages of each step."""

    def write(self, channel: str, _utime: int, data: bytes) -> None:
        if channel == Fired.CHANNEL:
            fired = decode(Fired, data)[2]
            self.fired.append((fired.stage, (fired.fired_us - START_US) // 1000))
            stamps = [(stamp - START_US) // 1000 for stamp in fired.stamps_us.tolist()]
            self.stamps_ms.setdefault(fired.stage, []).append(stamps)


def _taking(clock: Clock, step: Callable[..., Any], takes_s: float) -> Callable[..., Any]:
    def late(**inputs: Any) -> Any:
        clock.now_s += takes_s
        return step(**inputs)

    return late


@contextmanager
def scheduled(
    tmp_path: Path, at_ms: Sequence[int], **takes_s: float
) -> Iterator[tuple[LiveSchedule, Arrivals, Firings]]:
    """Yield the schedule of the graph, with pictures at some times, and stages whose steps take time."""
    path = tmp_path / "graph.yaml"
    path.write_text(GRAPH)
    catalog = Catalog()
    catalog.add_file(STAGES)
    graph = load_graph(path, catalog)
    clock = Clock()
    live_clock = LiveClock(lambda: clock.now_s, lambda: START_US * 1000)
    stages: dict[str, Stage] = graph.make_stages()
    for name, duration_s in takes_s.items():
        stage: Any = stages[name]
        stage.step = _taking(clock, stage.step, duration_s)
    intake = Intake(graph.inputs["camera.image"], live_clock, needs_all=False)
    arrivals, firings = Arrivals(clock, intake, at_ms), Firings()
    schedule = LiveSchedule(graph, stages, live_clock, [intake], arrivals, [], firings)
    with closing(schedule):
        yield schedule, arrivals, firings


def test_the_newest_picture_is_used_and_a_command_leaves_before_the_next_one_is_begun(tmp_path: Path) -> None:
    with scheduled(tmp_path, [10, 20, 30, 40, 150], slow=0.05) as (schedule, arrivals, firings):
        schedule.reset(0)
        assert schedule.run(0.3, arrivals.look, lambda: False) == "timeout"
    assert firings.fired == [
        ("guard", 0),  # its timer; there is no picture yet
        ("tick", 0),
        ("slow", 10),  # nearer to the end of the graph than see
        ("slow", 60),  # with the newest of the pictures that came in the meantime
        ("guard", 110),  # its timer, due at 100
        ("tick", 110),  # sources and stages take turns
        ("see", 110),
        ("both", 110),
        ("guard", 110),
        ("slow", 150),
        ("see", 200),
        ("both", 200),
        ("guard", 200),
        ("guard", 200),  # its timer, with the same command
        ("tick", 200),
    ]
    assert firings.stamps_ms["slow"] == [[10], [40], [150]]
    assert firings.stamps_ms["both"] == [[40, 40], [150, 150]]
    assert schedule.overtaken() == {"see.image": 3, "slow.image": 2, "both.b": 1}
    assert schedule.engine.units["slow"].missed == 3


def test_a_source_that_takes_longer_than_its_period_starves_no_stage(tmp_path: Path) -> None:
    with scheduled(tmp_path, [10], tick=0.15) as (schedule, arrivals, firings):
        schedule.reset(0)
        schedule.run(0.3, arrivals.look, lambda: False)
    assert firings.fired == [("guard", 0), ("tick", 0), ("guard", 150), ("slow", 150), ("tick", 150)]


def test_what_fails_before_the_first_step_is_told_at_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with scheduled(tmp_path, []) as (schedule, _, _):
        slow = schedule.engine.units["slow"]
        monkeypatch.setattr(slow.node.stage_class, "patience_s", lambda _: 1 / 0)
        with pytest.raises(StageError, match=r"^stage 'slow' \(probe\.brightness\) failed at 0\.00 s: patience_s: "):
            slow.patience_s()
