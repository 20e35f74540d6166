"""Graphs of stages that count, run in one process and in several."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from graphnav import About, Status
from graphnav.core.catalog import Catalog
from graphnav.core.codec import decode
from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Graph, graph_of
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Answer, Changes, Request, RunningRun, Summary, ask, new_run_id, run_recorded
from graphnav.processes.run import run_processes
from graphnav.processes.supervisor import Supervisor
from tests.live.conftest import live, load, outside  # noqa: F401 - fixtures

if TYPE_CHECKING:
    from tests.processes.over_ssh import Robot

STAGES = Path(__file__).parent / "stages.py"
LATE_ANSWERS = Path(__file__).parent / "late_answers.py"
"""A plugin with which a process answers each time after a random while."""
PATIENCE_S = 60.0
"""Longer than anything takes on a busy machine."""
OTHER_USER = 65_534
CONNECT = f"""
import os, socket, sys
os.setgroups([])
os.setgid({OTHER_USER})
os.setuid({OTHER_USER})
link = socket.socket(socket.AF_UNIX)
try:
    link.connect(sys.argv[1])
    print("connected", flush=True)
    link.sendall(bytes.fromhex(sys.argv[2]))
    link.settimeout({PATIENCE_S})
    print("answered" if link.recv(99) else "no answer")
except OSError as error:
    print("no answer" if isinstance(error, ConnectionError) else type(error).__name__)
"""

STEPS = """
run: {{until_s: 3, seed: 5}}
stages:
  clock: {{use: steps.count, with: {{n: 25, rate_hz: 10}}, in: {{heard: second.sum}}}}
  fast: {{use: steps.count, with: {{n: 1000, every_us: 33000}}}}
  even: {{use: steps.count, with: {{n: 1000, rate_hz: 5}}}}
  first: {{use: steps.pass, in: {{one: clock}}, with: {first}}}
  second: {{use: steps.add, in: {{one: first, old: third, others: fast}}}}
  third: {{use: steps.pass, in: {{one: second.sum}}, with: {third}}}
  slow: {{use: steps.add, with: {{takes_ms: 1}}, in: {{one: clock, old: second.late, others: second.late}}}}
  open: {{use: steps.add, in: {{one: third}}}}
  both: {{use: steps.both, in: {{one: even, two: open.sum}}}}
{more}{deploy}
"""
"""Irregular sources, loops, messages with stamps of their own, inputs that are open and joins that stay incomplete."""


class Ran:
    """Remains of a run: its log, its summary, the errors that it ended with, and what it told."""

    def __init__(
        self,
        folder: Path,
        summary: Summary,
        errors: list[GraphnavError],
        notices: list[str],
        answers: list[Answer],
    ) -> None:
        self.folder, self.summary, self.errors, self.notices = folder, summary, errors, notices
        self.answers = answers
        """Answers to the changes, in their order."""
        self.log = (folder / RunFolder.LOG).read_bytes()

    def agrees_with(self, other: Ran) -> bool:
        """Whether log, outcome, errors, metrics and counts are the same."""
        return self.log == other.log and self._told == other._told

    @property
    def _told(self) -> object:
        counts = {name: (did.steps, did.dropped) for name, did in self.summary.stages.items()}
        told = self.summary
        return told.outcome, told.failure, told.scores, told.frames, told.changes, counts


class Viewer:
    """A tap that keeps the statuses; when one tells of a process that is starting, it makes the file ``seen``."""

    def __init__(self, seen: Path) -> None:
        self.dropped, self.url = 0, ""
        self.statuses: list[Status] = []
        self._seen = seen

    def announce(self, about: About, shareable: Collection[str] = ()) -> None:
        """Hear what the run is."""

    def write(self, channel: str, _utime: int, data: bytes) -> None:
        if channel == Status.CHANNEL:
            self.statuses.append(decode(Status, data)[2])
            if any(process["state"] == "starting" for process in self.statuses[-1].processes):
                self._seen.touch()

    def close(self) -> None:
        """Leave."""


Runs = Callable[..., Ran]


class ChangesAt(Changes):
    """Changes of a run at stamps, s: requests that are made one after the other; a tick waits for the answers."""

    def __init__(self, graph: Graph, folder: Path, requests: Mapping[float, Sequence[Request]]) -> None:
        run_id = new_run_id()
        super().__init__(run_id, graph, Catalog().add_files(graph.plugins))
        self.answers: list[Answer] = []
        self._run = RunningRun(run_id, os.getpid(), "", folder, is_live=False, started_s=0.0, takes_changes=True)
        self._left = dict(requests)

    def take(self, utime: int, sinks: Sequence[Any], *, is_busy: bool = False) -> None:
        """Make the requests that are due, and let them take over."""
        for at_s in sorted(at_s for at_s in self._left if round(at_s * 1e6) <= utime):
            requests = self._left.pop(at_s)
            with ThreadPoolExecutor(max_workers=1) as pool:
                asked = [pool.submit(ask, self._run, request) for request in requests]
                while wait(asked, timeout=1e-3).not_done:
                    super().take(utime, sinks, is_busy=is_busy)
            self.answers += [answer.result() for answer in asked]


def request(*words: str, restart: str = "") -> Request:
    """Return a request, as the commands make it."""
    return Request(words, restart, os.getcwd())


def steps_graph(tmp_path: Path, deploy: str = "", first: str = "{}", third: str = "{}", more: str = "") -> Graph:
    """Return the graph of the stages that count, with ``more`` lines of stages."""
    text = STEPS.format(deploy=deploy, first=first, third=third, more=more)
    catalog = Catalog().add_files([STAGES])
    return replace(graph_of(text.encode(), tmp_path / "steps.yaml", catalog), plugins=(STAGES,))


def restarted(graph: Graph) -> Graph:
    """Return the graph with processes that are started again at once, as often as they end."""
    policy = {"restart": "on_failure", "max_restarts": 100, "restart_delay_s": 0.0}
    return replace(graph, deploy={part.name: replace(part, **policy) for part in graph.deploy.values()})  # type: ignore[arg-type]


def is_alive(pid: int) -> bool:
    """Whether a process exists and has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][0] != "Z"
    except OSError:
        return False


def wait_until(holds: Callable[[], bool]) -> None:
    """Wait for a condition."""
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s
        time.sleep(0.005)


def processes_of(probe: str) -> list[int]:
    """Return the living processes with a variable ``PROBE`` of this value in their environment."""
    found = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            variables = path.read_bytes().split(b"\0")
        except OSError:
            continue
        if f"PROBE={probe}".encode() in variables and is_alive(pid := int(path.parent.name)):
            found.append(pid)
    return found


class OtherUser:
    """A program of another user that connects to a socket, as only root can start one, and sends something."""

    def __init__(self, path: Path, said: bytes = b"") -> None:
        command = [sys.executable, "-I", "-c", CONNECT, str(path), said.hex()]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        self.first = self._process.stdout.readline().strip()
        """"connected", or the error."""

    def end(self) -> str:
        """Return what became of it: the error, or whether it was answered."""
        with self._process:
            assert self._process.stdout is not None
            # `communicate` would lose what was read ahead with the first line
            return self._process.stdout.read().strip() or self.first


@pytest.fixture
def runs(tmp_path: Path) -> Runs:
    """Return what runs a graph in one process, or in several where it names some.

    ``kills``: names by stamp, s. ``killed`` is called after each. ``changes``: requests by stamp, s.
    """
    n_runs = 0

    def run(
        graph: Graph,
        kills: dict[float, str] | None = None,
        killed: Callable[[Supervisor], None] = lambda _: None,
        changes: Mapping[float, Sequence[Request]] | None = None,
    ) -> Ran:
        nonlocal n_runs
        n_runs += 1
        folder = tmp_path / f"run{n_runs}"
        folder.mkdir()
        errors: list[GraphnavError] = []
        notices: list[str] = []
        given: list[Supervisor] = []
        left = dict(kills or {})

        def on_tick(utime: int) -> None:
            for at_s in [at_s for at_s in left if at_s * 1e6 <= utime]:
                kill(given[0], left.pop(at_s))
                killed(given[0])

        options: dict[str, Any] = {"on_tick": on_tick, "on_failure": errors.append, "notice": notices.append}
        with ChangesAt(graph, folder, changes or {}) as made:
            options["changes"] = made
            if graph.deploy:
                summary = run_processes(graph, graph.make_stages(), folder, supervised=given.append, **options)
            else:
                summary = run_recorded(graph, graph.make_stages(), folder, **options)
        return Ran(folder, summary, errors, notices, made.answers)

    return run


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    """Return a robot with a host; what is left there in the end is a fault."""
    from tests.processes.over_ssh import Robot  # it needs an extra

    made = Robot(tmp_path)
    yield made
    made.server.cut()
    wait_until(lambda: not made.is_left())
    made.server.close()


def kill(supervisor: Supervisor, name: str) -> None:
    """Kill a process of a run, unless it is just being started again."""
    if pid := supervisor.pid_of(name):
        os.kill(pid, signal.SIGKILL)
