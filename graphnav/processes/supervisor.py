"""Start the processes of a run, hear what they answer, start them again as the graph says, and end them."""

from __future__ import annotations

import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from graphnav import Graph, GraphnavError
from graphnav.core.graph import Part, part_yaml
from graphnav.core.interrupts import CtrlC, ctrl_c_later
from graphnav.core.machine import ONE_THREAD, peer_of
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import CODE, new_run_id, provenance
from graphnav.processes import child
from graphnav.processes.descriptors import is_readable
from graphnav.processes.journal import Journal
from graphnav.processes.output_lines import OutputLines
from graphnav.processes.restarts import Restarts, ending
from graphnav.processes.stage_process import StageProcess
from graphnav.processes.warden import VARIABLE, end_marked, remove_folder
from graphnav.processes.wardens import Wardens

_END_S = 1.0
"""How long a process may take to end by itself."""
_INTERRUPT_S = 0.5
"""How long a step may take to end after it was interrupted."""


class Running:
    """One process of a `StageProcess`, from its start to its end."""

    def __init__(self, popen: subprocess.Popen[bytes], mark: str, output: OutputLines) -> None:
        self.popen, self.mark, self.output = popen, mark, output
        self.pid_fd = os.pidfd_open(popen.pid)

    def has_ended_within(self, seconds: float) -> bool:
        """Wait for its end; it is not collected, so that its group is still its own."""
        return is_readable(self.pid_fd, seconds)


class Supervisor:
    """Owns the processes of a run; one thread uses it, the one that steps the stages.

    ``folder``: of the run. ``notice`` gets restarts, and what the stages print. ``is_asked_to_stop``: whether the user
    wants the run to end; then nothing is started any more.
    """

    def __init__(self, graph: Graph, folder: Path, notice: Callable[[str], None]) -> None:
        self.is_asked_to_stop: Callable[[], bool] = lambda: False
        self._folder, self._notice = folder, notice
        restarts = any(part.restart != "never" for part in graph.deploy.values())
        self._journal = Journal(folder) if restarts else None
        versions = _versions(graph)
        self.processes = {part.name: self._process(graph, part, versions) for part in graph.deploy.values()}
        """By the name of the part."""
        self.ends: dict[str, list[str]] = {name: [] for name in self.processes}
        """How each process ended before the run did."""
        self._restarts = {name: Restarts(part) for name, part in graph.deploy.items()}
        self._due_s: dict[str, float] = {}
        """When processes are started again, monotonic seconds."""
        self._running: dict[str, Running] = {}
        self._epochs = dict.fromkeys(self.processes, 0)
        self._run = new_run_id()
        self._sockets, self._listener = _listening(len(self.processes))
        self._poll = select.poll()
        self._poll.register(self._listener, select.POLLIN)
        self._wardens = Wardens(f"{self._run}/", self._sockets)
        self._is_closing = False

    @property
    def warden_pid(self) -> int:
        """The process of the warden."""
        return self._wardens.pid

    def pid_of(self, name: str) -> int | None:
        """Return the number of a process, None while there is none."""
        running = self._running.get(name)
        return None if running is None else running.popen.pid

    def start(self) -> None:
        """Start all processes; each is ready when it has answered its first frame."""
        for name in self.processes:
            self._start(name)

    def order_reset(self, seed: int) -> None:
        """Let all processes begin to reset their stages by the seed of the run."""
        for process in self.processes.values():
            process.ordered_reset(seed)

    def wait(self, timeout_s: float | None = None) -> None:
        """Wait for something to happen to the processes: an answer, a start, an end; handle it.

        Raises
        ------
        CtrlC
            A process is due to be started again, but the user has asked the run to stop.
        """
        now_s = time.monotonic()
        due_s = min(self._due_s.values(), default=None)
        waits = [s for s in (timeout_s, None if due_s is None else max(0.0, due_s - now_s)) if s is not None]
        ready = {fd for fd, _ in self._poll.poll(min(waits) * 1e3 if waits else None)}
        if self._listener.fileno() in ready:
            self._accept()
        for name, process in self.processes.items():
            running = self._running.get(name)
            if running is not None and process.link is not None and process.link.fileno() in ready:
                self._read(name, process)
        for name, running in list(self._running.items()):
            if running.pid_fd in ready:
                self._ended(name)
        for name in [name for name, due_s in self._due_s.items() if due_s <= time.monotonic()]:
            del self._due_s[name]
            if self.is_asked_to_stop():
                self.processes[name].give_up("its process is not started again: the run is to stop")
                raise CtrlC
            self._start(name)

    def interrupt(self) -> None:
        """Break off the steps in progress, and end the processes that do not obey: the user does not wait for them."""
        for name, process in self.processes.items():
            process.drop_pending()
            running = self._running.get(name)
            if process.is_busy and running is not None and process.link is not None:
                process.is_interrupted = True
                running.popen.send_signal(signal.SIGINT)
            elif not process.is_down and process.link is None:
                self._end(name, "its process was not ready when the run was stopped")
        end_s = time.monotonic() + _INTERRUPT_S
        busy = [name for name, process in self.processes.items() if process.is_busy]
        while busy and (left_s := end_s - time.monotonic()) > 0:
            self.wait(left_s)
            busy = [name for name in busy if self.processes[name].is_busy]
        for name in busy:
            self._end(name, "its process did not end its step when the run was stopped")

    def report(self) -> dict[str, Any]:
        """Return what became of the processes, for the summary."""
        return {
            name: {"stages": [node.name for node in process.nodes], "ended": self.ends[name]}
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
                self._listener.close()
                end_marked(f"{self._run}/")
                remove_folder(self._sockets)
                self._wardens.close()
                if self._journal is not None:
                    self._journal.close()

    def _process(self, graph: Graph, part: Part, versions: dict[str, str]) -> StageProcess:
        nodes = [node for node in graph.nodes if node.name in part.stages]
        families = {f"{CODE}{node.use.partition('.')[0]}" for node in nodes}
        setup = {
            "graph": part_yaml(graph, part.stages),
            "path": str(graph.path),
            "read": sorted(graph.read),
            "plugins": [str(path) for path in graph.plugins],
            "versions": {name: v for name, v in versions.items() if not name.startswith(CODE) or name in families},
        }
        return StageProcess(part, nodes, setup, self._journal if part.restart != "never" else None)

    def _start(self, name: str) -> None:
        try:
            self._started(name)
        except OSError as error:
            self.processes[name].give_up(f"its process '{name}' cannot be started: {error.strerror or error}")

    def _started(self, name: str) -> None:
        self._epochs[name] += 1
        mark = f"{self._run}/{name}/{self._epochs[name]}"
        marks = " ".join(filter(None, (os.environ.get(VARIABLE), mark)))
        command = [sys.executable, "-u", "-P", "-m", child.__name__, self._listener.getsockname(), str(os.getpid())]
        with ctrl_c_later():
            popen = subprocess.Popen(  # noqa: S603 - it is this program
                command,
                env=os.environ | ONE_THREAD | {VARIABLE: marks},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            self._wardens.add(popen.pid)
            assert popen.stdout is not None, "it has a pipe"
            file = self._folder / RunFolder.OUTPUT / f"{name}.txt"
            running = Running(popen, mark, OutputLines(name, popen.stdout, file, self._notice))
            self._running[name] = running
            self._poll.register(running.pid_fd, select.POLLIN)

    def _accept(self) -> None:
        """Take the connection of one of the processes; close that of any other."""
        link, _ = self._listener.accept()
        pid, user = peer_of(link)
        for name, running in self._running.items():
            if running.popen.pid == pid and user == os.getuid() and self.processes[name].link is None:
                self._poll.register(link, select.POLLIN)
                try:
                    self.processes[name].connected(link)
                except GraphnavError as error:
                    self._end(name, f"its process '{name}' cannot be started again: {error}")
                return
        link.close()

    def _read(self, name: str, process: StageProcess) -> None:
        try:
            process.read()
        except (EOFError, OSError):
            self._unregister(process)
            if not self._running[name].has_ended_within(_END_S):  # only its side of the connection has
                self._running[name].popen.kill()
        except ValueError as error:
            self._end(name, f"its process '{name}' failed: {error}")
        except GraphnavError as error:
            self._end(name, f"its process '{name}' cannot go on: {error}")

    def _ended(self, name: str) -> None:
        """Start a process again that has ended, as the graph says."""
        process = self.processes[name]
        if process.has_answered():  # what it said before it ended
            self._read(name, process)
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
            hint = f"write deploy: {{{name}: {{{words}}}}} to have it started again and fed what it was given"
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

    def _end(self, name: str, why: str) -> None:
        """End a process for good."""
        self._due_s.pop(name, None)
        if name in self._running:
            self._running[name].popen.kill()
            self._reap(name)
        self.processes[name].give_up(why)

    def _reap(self, name: str, *, scans: bool = True) -> int:
        """Collect a process, which is killed if it runs, and end what it has started; return its exit status."""
        running = self._running.pop(name)
        process = self.processes[name]
        self._unregister(process)
        process.disconnected()
        with suppress(OSError):
            os.killpg(running.popen.pid, signal.SIGKILL)
        status = running.popen.wait()
        if scans:
            end_marked(running.mark)
        self._wardens.remove(running.popen.pid)
        self._poll.unregister(running.pid_fd)
        os.close(running.pid_fd)
        running.output.close()
        return status

    def _unregister(self, process: StageProcess) -> None:
        if process.link is not None:
            with suppress(KeyError):
                self._poll.unregister(process.link)


def _versions(graph: Graph) -> dict[str, str]:
    """Return what the processes must have as this one has it: versions, and the code of the stages."""
    return provenance({node.use.partition(".")[0] for node in graph.nodes}, [str(path) for path in graph.plugins])


def _listening(backlog: int) -> tuple[str, socket.socket]:
    """Return the folder of the socket to which the processes connect, which is this user's alone, and the socket.

    Raises
    ------
    GraphnavError
        There is no place for it.
    """
    try:
        folder = tempfile.mkdtemp(prefix="graphnav-")  # its mode is 0700
        listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        listener.bind(os.path.join(folder, "run"))
        listener.listen(backlog)
    except OSError as error:
        where = tempfile.gettempdir()
        raise GraphnavError(
            f"no socket in {where} for the processes: {error}\n  set TMPDIR to another folder"
        ) from error
    return folder, listener
