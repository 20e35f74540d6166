"""Start the processes of a run, hear what they answer, start them again as the graph says, and end them."""

from __future__ import annotations

import select
import signal
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from graphnav import Graph, GraphnavError
from graphnav.core.graph import Node, Part, part_yaml
from graphnav.core.interrupts import CtrlC, ctrl_c_later
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import CODE, ProcessState, new_run_id, provenance
from graphnav.processes import child, host_proxy
from graphnav.processes.children import Children, Running
from graphnav.processes.frames import Frame, Kind, keep_freed_memory, send
from graphnav.processes.host_clock_notices import HostClockNotices
from graphnav.processes.hosts import Host, fingerprint, hosts_of
from graphnav.processes.journal import Journal
from graphnav.processes.output_lines import OutputLines
from graphnav.processes.restarts import Restarts, ending
from graphnav.processes.stage_process import StageProcess

_END_S = 1.0
"""How long a process may take to end by itself."""
_ANSWER_S = 5.0
"""How long a process of a live run may take to answer what is not a step, such as for its metrics."""
_LOOK_S = 1.0
"""How long `Supervisor.wait` waits at most, since the run may have something to tell."""
_INTERRUPT_S = 0.5
"""How long a step may take to end after it was interrupted."""


class Supervisor:
    """Owns the processes of a run; one thread uses it, the one that steps the stages.

    ``folder``: of the run. ``notice`` gets restarts, and what the stages print. ``is_asked_to_stop``: whether the user
    wants the run to end; then nothing is started any more. ``is_live``: a process that is started again is reset, and
    not fed what the one before was given. ``hosts``: where the hosts are that the graph names, None: as `hosts_of`
    finds them. A process on a host is one here, which stands for it (`host_proxy`).
    """

    def __init__(
        self,
        graph: Graph,
        folder: Path,
        notice: Callable[[str], None],
        *,
        is_live: bool = False,
        hosts: Mapping[str, Host] | None = None,
    ) -> None:
        self._hosts = hosts_of(graph) if hosts is None else hosts
        self._fingerprints = {name: fingerprint(graph, name) for name in self._hosts}
        self.is_asked_to_stop: Callable[[], bool] = lambda: False
        self.while_waiting: Callable[[], None] = lambda: None
        """Called whenever `wait` returns."""
        self._folder, self._notice = folder, notice
        self.order = 0, 0
        """Of the reset of all stages: the seed of the run, and its clock at the start, microseconds."""
        self._is_live = is_live
        self.answer_within_s = _ANSWER_S if is_live else None
        """How long a process may take to answer what is not a step, None for as long as it likes."""
        restarts = any(part.restart != "never" for part in graph.deploy.values())
        self._journal = Journal(folder) if restarts and not is_live else None
        self._versions = _versions(graph)
        if graph.deploy:
            keep_freed_memory()
        self.processes = {part.name: self._process(graph, part) for part in graph.deploy.values()}
        """By the name of the part."""
        self.ends: dict[str, list[str]] = {name: [] for name in self.processes}
        """How each process ended before the run did."""
        self._clocks = HostClockNotices(notice)
        self._restarts = {name: Restarts(part) for name, part in graph.deploy.items()}
        self._due_s: dict[str, float] = {}
        """When processes are started again, monotonic seconds."""
        self._killed_s: dict[str, float] = {}
        """When processes are killed that have closed their side of the connection and have not ended, the same."""
        self._lost: set[str] = set()
        self._lost_s: dict[str, float] = {}
        """When processes ended that are not back, monotonic seconds."""
        self._ended: dict[str, None] = {}
        """The processes whose end the last `wait` has met: those who wait learn of it before time is spent on it."""
        self._running: dict[str, Running] = {}
        self._epochs = dict.fromkeys(self.processes, 0)
        self._run = new_run_id()
        self._children = Children(self._run, len(self.processes))
        self._poll = select.poll()
        self._poll.register(self._children.listener, select.POLLIN)
        self._sending: set[str] = set()
        self._is_closing = False

    @property
    def warden_pid(self) -> int:
        """The process of the warden."""
        return self._children.warden_pid

    def pid_of(self, name: str) -> int | None:
        """Return the number of a process, None while there is none."""
        running = self._running.get(name)
        return None if running is None else running.popen.pid

    def start(self) -> None:
        """Start all processes; each is ready when it has answered its first frame."""
        for name in self.processes:
            self._start(name)

    def await_ready(self) -> None:
        """Wait until all processes have made their stages, or are down."""
        while not all(process.is_made or process.is_down for process in self.processes.values()):
            self.wait()

    def order_reset(self, seed: int, begin_us: int = 0) -> None:
        """Let all processes begin to reset their stages by the seed of the run, and its clock at the start."""
        self.order = seed, begin_us
        for process in self.processes.values():
            process.ordered_reset(self.order)

    def wait(self, timeout_s: float | None = None) -> None:
        """Wait, a second at most, for something to happen to the processes: an answer, a start, an end; handle it.

        Raises
        ------
        CtrlC
            A process is due to be started again, but the user has asked the run to stop.
        """
        ended, self._ended = self._ended, {}
        for name in ended:
            self._follow(name)
        wait_s = self._wait_s(0.0 if ended else timeout_s)
        ready = dict(self._poll.poll(wait_s * 1e3))
        if self._children.listener.fileno() in ready:
            self._accept()
        for name, process in self.processes.items():
            if process.link is not None and (events := ready.get(process.link.fileno())):
                self._serve(name, process, events)
        self._ended = {name: None for name, running in self._running.items() if running.pid_fd in ready}
        for name in self._ended:
            self._note_end(name)
        self._begin_due()
        self.while_waiting()

    def _wait_s(self, timeout_s: float | None) -> float:
        """Return how long to wait at most; let the poll look at what can be sent."""
        for name, process in self.processes.items():
            if process.link is not None and process.link.is_sending != (name in self._sending):
                self._sending ^= {name}
                self._poll.modify(process.link, select.POLLIN | select.POLLOUT * process.link.is_sending)
        times_s = [*self._due_s.values(), *self._killed_s.values()]
        waits = [_LOOK_S] if timeout_s is None else [_LOOK_S, timeout_s]
        if times_s:
            waits.append(max(0.0, min(times_s) - time.monotonic()))
        return min(waits)

    def _begin_due(self) -> None:
        """Kill and start what is due."""
        for name in [name for name, due_s in self._killed_s.items() if due_s <= time.monotonic()]:
            del self._killed_s[name]
            self._running[name].popen.kill()
        for name in [name for name, due_s in self._due_s.items() if due_s <= time.monotonic()]:
            del self._due_s[name]
            if self.is_asked_to_stop():
                self.processes[name].give_up("its process is not started again: the run is to stop")
                raise CtrlC
            self._start(name)

    def watch(self, fd: int) -> None:
        """Let `wait` also return when a descriptor is readable."""
        self._poll.register(fd, select.POLLIN)

    def take_lost(self) -> Collection[str]:
        """Return the stages whose processes have ended since the last call."""
        lost, self._lost = self._lost, set()
        return [node.name for name, process in self.processes.items() if name in lost for node in process.nodes]

    def interrupt(self) -> None:
        """Break off the steps in progress, and end the processes that do not obey: the user does not wait for them."""
        for name, process in self.processes.items():
            process.drop_pending()
            running = self._running.get(name)
            if process.is_busy and running is not None and process.link is not None:
                process.is_interrupted = True
                running.popen.send_signal(signal.SIGINT)
            elif not process.is_down and process.link is None:
                self.end(name, "it was not ready when the run was stopped")
        end_s = time.monotonic() + _INTERRUPT_S
        busy = [name for name, process in self.processes.items() if process.is_busy]
        while busy and (left_s := end_s - time.monotonic()) > 0:
            self.wait(left_s)
            busy = [name for name in busy if self.processes[name].is_busy]
        for name in busy:
            self.end(name, "it did not end its step when the run was stopped")

    def states(self) -> Sequence[ProcessState]:
        """Return how the processes are at the moment."""
        return [
            ProcessState(
                name,
                tuple(node.name for node in process.nodes),
                self.pid_of(name) or 0,
                self._state_of(name, process),
                process.restarts,
                **self._clocks.fields(process.part, process.clock),
            )
            for name, process in self.processes.items()
        ]

    def report(self) -> dict[str, Any]:
        """Return what became of the processes, for the summary."""
        return {
            name: {
                "stages": [node.name for node in process.nodes],
                "restarts": process.restarts,
                "ended": self.ends[name],
                **self._clocks.report(process.part),
            }
            for name, process in self.processes.items()
        }

    def close(self) -> None:
        """End all processes, those that do not end by themselves at once."""
        self._is_closing = True
        try:
            for process in self.processes.values():
                process.disconnected()
            end_s = time.monotonic() + _END_S
            for running in self._running.values():
                running.has_ended_within(max(0.0, end_s - time.monotonic()))
        finally:
            with ctrl_c_later():
                for name in list(self._running):
                    self._reap(name, scans=False)
                self._children.close()
                if self._journal is not None:
                    self._journal.close()

    def _state_of(self, name: str, process: StageProcess) -> Literal["starting", "ready", "restarting", "given up"]:
        if process.is_down:
            return "given up"
        if process.is_ready:
            return "ready"
        return "restarting" if name in self._lost_s or self.ends[name] else "starting"

    def _process(self, graph: Graph, part: Part) -> StageProcess:
        nodes = [node for node in graph.nodes if node.name in part.stages]
        journal = self._journal if part.restart != "never" else None
        return StageProcess(part, nodes, self._setup(graph, part), journal, is_live=self._is_live)

    def _setup(self, graph: Graph, part: Part) -> dict[str, Any]:
        """Return what a process is told of its stages when it starts."""
        families = {f"{CODE}{node.family}" for node in graph.nodes if node.name in part.stages}
        return {
            "path": str(graph.path),
            "read": sorted(graph.read),
            "plugins": [str(path) for path in graph.plugins],
            "graph": part_yaml(graph, part.stages),
            "versions": {
                name: version
                for name, version in self._versions.items()
                if not name.startswith(CODE) or name in families
            },
        }

    def versions_of(self, node: Node) -> dict[str, str]:
        """Return the version of the code of a stage as the run has it; empty if it has none so far."""
        name = f"{CODE}{node.family}"
        return {name: self._versions[name]} if name in self._versions else {}

    def note_change(self, process: StageProcess, graph: Graph, versions: Mapping[str, str]) -> None:
        """Let a new process of a live run begin with the stages of another graph; ``versions``: of their code.

        In lockstep it begins as the first one did, and is given the change again, too.
        """
        self._versions = {**versions, **self._versions}
        if self._is_live:
            process.setup = self._setup(graph, process.part)

    def _start(self, name: str) -> None:
        try:
            self._started(name)
        except OSError as error:
            self.processes[name].give_up(f"its process '{name}' cannot be started: {error.strerror or error}")

    def _started(self, name: str) -> None:
        self._epochs[name] += 1
        self.processes[name].restarts = self._epochs[name] - 1
        module = child if self.processes[name].part.host is None else host_proxy
        file = self._folder / RunFolder.OUTPUT / f"{name}.txt"
        with ctrl_c_later():
            running = self._running[name] = self._children.start(
                f"{name}/{self._epochs[name]}",
                module.__name__,
                lambda stream: OutputLines(name, stream, file, self._notice),
            )
            self._poll.register(running.pid_fd, select.POLLIN)

    def _join(self, part: Part) -> Frame:
        """Return what the process that stands for one on a host is told: where that is, and what to say to it."""
        assert part.host is not None, "it stands for one elsewhere"
        host = self._hosts[part.host]
        join = {"run": self._run, "part": part.name, "host": host.name, "graph": self._fingerprints[part.host]}
        return Frame(Kind.JOIN, {"at": host.address, "port": host.port, "key": host.key.hex(), "join": join})

    def _accept(self) -> None:
        """Take the connection of one of the processes; close that of any other."""
        waiting = {
            running.popen.pid: name for name, running in self._running.items() if self.processes[name].link is None
        }
        found = self._children.accept(waiting.keys())
        if found is None:
            return
        name, link = waiting[found[0]], found[1]
        self._poll.register(link, select.POLLIN)
        part = self.processes[name].part
        try:
            if part.host is not None:
                with suppress(OSError):  # it has ended, which its descriptor tells
                    send(link, self._join(part))
            self.processes[name].connected(link)
        except GraphnavError as error:
            self.end(name, f"cannot be started again: {error}")

    def _serve(self, name: str, process: StageProcess, events: int) -> None:
        """Send a process more of what it was asked, and read what it answers."""
        assert process.link is not None, "it is polled"
        try:
            if events & select.POLLOUT:
                process.link.send_more()
            if events & ~select.POLLOUT:
                process.read()
        except (EOFError, OSError):
            self._disconnect(process)
            self._killed_s[name] = time.monotonic() + _END_S  # if only its side of the connection has ended
        except ValueError as error:
            self.end(name, f"failed: {error}")
        except GraphnavError as error:
            self.end(name, f"cannot go on: {error}")
        self._clocks.look(process.part, process.clock)
        if self._is_live and process.is_free and (lost_s := self._lost_s.pop(name, None)) is not None:
            self._notice(f"process '{name}' is back after {time.monotonic() - lost_s:.1f} s")

    def _note_end(self, name: str) -> None:
        """Take what a process said before it ended."""
        process = self.processes[name]
        while process.link is not None and process.has_answered():
            self._serve(name, process, select.POLLIN)
        self._disconnect(process)

    def _follow(self, name: str) -> None:
        """Start a process again that has ended, as the graph says."""
        process = self.processes[name]
        if name not in self._running:
            return
        status = self._reap(name)
        how = ending(status)
        self.ends[name].append(how)
        if self._is_closing or process.is_down:
            return
        self._restart_or_give_up(name, status, how)

    def _restart_or_give_up(self, name: str, status: int, how: str) -> None:
        process, restarts = self.processes[name], self._restarts[name]
        part = process.part
        if not restarts.may_follow(status):
            policy = "on_failure" if status else "always"
            words = f"stages: [{', '.join(part.stages)}], restart: {policy}"
            fed = "" if self._is_live else " and fed what it was given"
            hint = f"write deploy: {{{name}: {{{words}}}}} to have it started again{fed}"
            process.give_up(f"its process '{name}' {how}", hint)
            return
        if self._journal is not None and self._journal.fault:
            process.give_up(f"its process '{name}' {how}, and {self._journal.fault}")
            return
        now_s = time.monotonic()
        delay_s = restarts.delay_s(now_s)
        if delay_s is None:
            times = f"{part.max_restarts} restart{'s' if part.max_restarts > 1 else ''} in {part.restart_window_s:g} s"
            process.give_up(f"its process '{name}' {how}, and is given up after {times}")
            return
        self._due_s[name] = now_s + delay_s
        self._notice(
            f"process '{name}' {how}: it is started again in {delay_s:g} s ({restarts.count} of {part.max_restarts})"
        )

    def end(self, name: str, why: str) -> None:
        """End a process for good; ``why``: what it did, after its name."""
        self._due_s.pop(name, None)
        if name in self._running:
            self._running[name].popen.kill()
            self._reap(name)
        self.processes[name].give_up(f"its process '{name}' {why.removeprefix('it ')}")

    def _reap(self, name: str, *, scans: bool = True) -> int:
        """Collect a process, which is killed if it runs, and end what it has started; return its exit status."""
        running = self._running.pop(name)
        self._disconnect(self.processes[name])
        self._killed_s.pop(name, None)
        self._poll.unregister(running.pid_fd)
        return self._children.reap(running, scans=scans)

    def _disconnect(self, process: StageProcess) -> None:
        if process.link is not None:
            self._poll.unregister(process.link)
            self._sending.discard(process.part.name)
            self._lost.add(process.part.name)
            self._lost_s[process.part.name] = time.monotonic()
        process.disconnected()


def _versions(graph: Graph) -> dict[str, str]:
    """Return what the processes must have as this one has it: versions, and the code of the stages."""
    return provenance({node.family for node in graph.nodes}, [str(path) for path in graph.plugins])
