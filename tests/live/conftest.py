"""Live runs of the probe stages in a thread, on a multicast group of their own, and a program outside."""

from __future__ import annotations

import os
import textwrap
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphnav import Image, Odometry, Recording, Twist
from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.codec import decode, encode
from graphnav.core.graph import Graph, Override, load_graph
from graphnav.core.messages import Message
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Answer, Changes, Request, RunningRun, Summary, ask, new_run_id
from graphnav.live.run import run_live
from graphnav.processes.run import run_live_processes
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay

STAGES = Path(__file__).parent / "stages.py"
PATIENCE_S = 20.0


class Outside:
    """A program outside of graphnav: it publishes what it is told and keeps what it hears."""

    def __init__(self, url: str, listens: Sequence[str]) -> None:
        self.heard: list[tuple[str, bytes, float]] = []
        self._out = Bus(url)
        self._seqs: dict[str, int] = {}
        self._ending = threading.Event()
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._listen, args=(url, listens))
        self._thread.start()
        self._ready.wait(PATIENCE_S)

    def say(self, channel: str, message: Message, utime: int | None = None) -> int:
        """Publish a message, stamped now unless said otherwise; return its stamp."""
        stamp = time.time_ns() // 1000 if utime is None else utime
        seq = self._seqs[channel] = self._seqs.get(channel, -1) + 1
        self._out.publish(channel, encode(message, stamp, seq))
        return stamp

    def lose(self, channel: str, count: int) -> None:
        """Number so many messages that never arrive."""
        self._seqs[channel] = self._seqs.get(channel, -1) + count

    def show(self, channel: str, level: int, utime: int | None = None, size: tuple[int, int] = (24, 32)) -> int:
        """Publish a picture of one gray level; return its stamp."""
        return self.say(channel, Image(pixels=np.full(size, level, np.uint8)), utime)

    def speeds(self, channel: str) -> list[tuple[int, float]]:
        """Return stamp and speed of every twist that was heard on a channel."""
        decoded = [decode(Twist, data) for data in self.of(channel)]
        return [(utime, twist.v_mps) for utime, _, twist in decoded]

    def say_bytes(self, channel: str, data: bytes) -> None:
        """Publish bytes as they are."""
        self._out.publish(channel, data)

    def of(self, channel: str) -> list[bytes]:
        """Return what was heard on a channel."""
        return [data for name, data, _ in self.heard if name == channel]

    def wait_for(self, holds: Callable[[], bool]) -> None:
        """Wait until something holds; fail where it never does."""
        end_s = time.monotonic() + PATIENCE_S
        while not holds():
            assert time.monotonic() < end_s, "it never came"
            time.sleep(0.005)

    def close(self) -> None:
        """Leave."""
        self._ending.set()
        self._thread.join()
        self._out.close()

    def _listen(self, url: str, listens: Sequence[str]) -> None:
        bus = Bus(url)
        for channel in listens:
            bus.subscribe(channel, lambda name, data: self.heard.append((name, data, time.monotonic())))
        self._ready.set()
        while not self._ending.is_set():
            bus.handle(0.02)
        bus.close()


class Live:
    """A live run in a thread; `stop` ends it, `changed` changes it while it lasts."""

    def __init__(self, graph: Graph, folder: Path, url: str, plugins: Sequence[Path], **options: Any) -> None:
        self.folder, self._plugins, self._run_id = folder, plugins, new_run_id()
        self.notices: list[str] = []
        self._summary: Summary | None = None
        self._error: BaseException | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(graph, url, options))
        self._thread.start()

    def changed(self, *words: str) -> Answer:
        """Ask the run for a change; return what became of it."""
        run = RunningRun(self._run_id, os.getpid(), "", self.folder, is_live=True, started_s=0.0, takes_changes=True)
        return ask(run, Request(words, "", os.getcwd()))

    def stop(self) -> tuple[Summary, Recording]:
        """End the run and return what it left."""
        self._stopping.set()
        return self.finish()

    def finish(self) -> tuple[Summary, Recording]:
        """Wait for the end of the run and return what it left."""
        self._thread.join(3 * PATIENCE_S)
        assert not self._thread.is_alive(), "the run does not end"
        if self._error is not None:
            raise self._error
        assert self._summary is not None
        return self._summary, Recording(self.folder / RunFolder.LOG)

    def _run(self, graph: Graph, url: str, options: dict[str, Any]) -> None:
        try:
            run = partial(run_live_processes, run_live) if graph.deploy else run_live
            with Changes(self._run_id, graph, Catalog().add_files(self._plugins)) as changes:
                self._summary = run(
                    graph,
                    graph.make_stages(),
                    self.folder,
                    url=url,
                    notice=self.notices.append,
                    should_stop=self._stopping.is_set,
                    changes=changes,
                    **options,
                )
        except BaseException as error:  # noqa: BLE001 - told by finish()
            self._error = error


@pytest.fixture
def plugins() -> Sequence[Path]:
    """Return further files of stages."""
    return ()


@pytest.fixture
def load(tmp_path: Path, plugins: Sequence[Path]) -> Callable[[str], Graph]:
    """Return a function that loads a graph from its text."""

    def load_text(text: str) -> Graph:
        path = tmp_path / "graph.yaml"
        path.write_text(textwrap.dedent(text))
        catalog = Catalog()
        catalog.add_files([STAGES, *plugins])
        return load_graph(path, catalog)

    return load_text


@pytest.fixture
def live(
    tmp_path: Path, group: str, load: Callable[[str], Graph], plugins: Sequence[Path]
) -> Iterator[Callable[..., Live]]:
    """Return a function that begins a live run of a graph's text."""
    runs: list[Live] = []

    def begin(text: str, name: str = "run", url: str = group, *, processes: bool = False, **options: Any) -> Live:
        folder = tmp_path / name
        folder.mkdir()
        graph = load(text).with_processes() if processes else load(text)
        if graph.deploy:
            graph = replace(graph, plugins=(STAGES, *plugins))
        runs.append(Live(graph, folder, url, [STAGES, *plugins], **options))
        return runs[-1]

    yield begin
    for run in runs:
        run._stopping.set()
        run._thread.join()


@pytest.fixture
def outside(group: str) -> Iterator[Callable[..., Outside]]:
    """Return a function that makes a program outside, listening to some channels."""
    made: list[Outside] = []

    def make(*listens: str) -> Outside:
        made.append(Outside(group, listens))
        return made[-1]

    yield make
    for one in made:
        one.close()


EVERY_KIND = """
run: {until_s: 30, record: all}
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  base.odometry: {channel: ODOMETRY, type: graphnav_lcm.odometry_t}
stages:
  tick:   {use: probe.ticker, with: {rate_hz: 50}, in: {command: guard.twist}}
  see:    {use: probe.brightness, in: {image: camera.image}}
  slow:   {use: probe.brightness, with: {dawdle_s: 0.03}, in: {image: camera.image}}
  both:   {use: probe.both, in: {a: see.twist, b: slow.twist}}
  gather: {use: probe.gather, in: {image: camera.image, odometry: base.odometry}}
  guard:  {use: probe.pass, every_ms: 20, in: {command: both.twist, image: camera.image}}
outputs: {guard.twist: {channel: SPEED, motor: false}}
"""


@pytest.fixture
def every_kind() -> str:
    """Return a graph with timers, a source, joins and inputs that are read in all three ways."""
    return EVERY_KIND


@pytest.fixture
def log(live: Callable[..., Live], outside: Callable[..., Outside]) -> Path:
    """Return the log of a run of that graph."""
    program = outside("SPEED")
    run = live(EVERY_KIND)
    program.wait_for(lambda: bool(program.of("SPEED")))
    for level in range(40):
        for _ in range(3):
            program.say("ODOMETRY", Odometry(x_m=0.1 * level, y_m=0.0, yaw_rad=0.0, v_mps=1.0, omega_radps=0.0))
        program.show("CAMERA", level)
        time.sleep(0.015)
    program.wait_for(lambda: any(v > 0 for _, v in program.speeds("SPEED")))
    run.stop()
    return run.folder / "run.lcmlog"


@pytest.fixture
def again() -> Callable[..., ReplayResult]:
    """Return a function that replays a log of that graph with swaps: ``out``, and the words of `ReplayOptions`."""

    def run(log: Path, *sets: str, out: Path | None = None, **options: Any) -> ReplayResult:
        catalog = Catalog()
        catalog.add_file(STAGES)
        with Recording(log) as recording:
            made = graph_to_replay(recording, catalog, overrides=[*map(Override.parse, ("slow.dawdle_s=0", *sets))])
            return replay(recording, made, ReplayOptions(**options), out=out)

    return run
