"""The process that stands in a run for one on another host: it passes on what both say, and ends as that one ends.

``python -m graphnav.processes.host_proxy ADDRESS PARENT``; the rest it is told by the run.
"""

from __future__ import annotations

import os
import resource
import select
import signal
import sys
import time
from typing import NoReturn

from graphnav import GraphnavError
from graphnav.core.notices import print_notice
from graphnav.processes.child import connected
from graphnav.processes.frames import Frame, Kind, Link, receive
from graphnav.processes.host_link import HostCaller, HostLink, LinkError, Refusal, events_of
from graphnav.processes.hosts import SERVICE

_LOOK_S = 0.05
_PATIENCE_S = 1.0
"""So long a host that is not there is not reported."""


class HostProxy:
    """Passes frames between the run, which is ``link``, and a host. ``join``: what the host is told first."""

    def __init__(self, link: Link, caller: HostCaller, name: str, join: Frame) -> None:
        self._run, self._caller, self._name, self._join = link, caller, name, join
        self._host: HostLink | None = None
        self._is_interrupted = False
        self._told = ""
        self._n_answers = 0
        """About the clock of the host, those that were passed on."""
        self._begin_s = time.monotonic()

    def interrupt(self, _number: int, _frame: object) -> None:
        """Let the host break off the step, at a signal."""
        self._is_interrupted = True

    def serve(self) -> NoReturn:
        """Pass on until the run closes its side, or the process there has ended.

        Raises
        ------
        EOFError, OSError
            The run is gone.
        GraphnavError
            The host is.
        """
        while True:
            ready = self._ready()
            if self._host is None:
                self._call(ready)
            else:
                self._pass_on(self._host, ready)

    def _ready(self) -> dict[int, int]:
        """Wait for something to happen; what the run says waits while the host is not there, or behind with reading."""
        poll = select.poll()
        is_reading = self._host is not None and not self._host.is_sending
        poll.register(self._run.fileno(), select.POLLIN * is_reading | select.POLLOUT * self._run.is_sending)
        if self._host is not None:
            poll.register(self._host.fileno(), events_of(self._host))
        else:
            for fd, events in self._caller.pollables():
                poll.register(fd, events)
        return dict(poll.poll(_LOOK_S * 1e3))

    def _call(self, ready: dict[int, int]) -> None:
        """Go on with calling the host, and say why it does not answer."""
        if self._run.fileno() in ready:
            raise EOFError
        try:
            proven = self._caller.step(ready.keys(), 0)
        except LinkError as error:
            self._refuse(str(error))
        for link in proven:
            self._host = link
            link.send(self._join)
            if self._told:
                print_notice(f"the host {self._name} is there")
        why = self._caller.failure
        if why and not self._told and time.monotonic() - self._begin_s > _PATIENCE_S:
            self._told = why
            started = f"graphnav run GRAPH --host {self._name}"
            print_notice(f"waits for the host {self._name}, on which '{started}' has to run ({why})")

    def _pass_on(self, host: HostLink, ready: dict[int, int]) -> None:
        host.tick(time.monotonic())
        if self._is_interrupted:
            self._is_interrupted = False
            host.send(Frame(Kind.INTERRUPT, None))
        if host.fileno() in ready:
            host.send_more()
            while (frame := host.receive()) is not None:
                if frame.kind == Kind.ENDED:
                    _end_as(int(frame.head))
                if frame.kind == Kind.CLOCK:
                    raise LinkError(f"{host.peer} sent what only this machine can measure", Refusal.FOREIGN)
                self._run.send(frame)
        if self._run.fileno() in ready:
            self._run.send_more()
            while (asked := self._run.receive()) is not None:
                host.send(asked)
        if host.clock.n_answers != self._n_answers and not self._run.is_sending:
            self._n_answers = host.clock.n_answers
            self._run.send(Frame(Kind.CLOCK, host.clock_state()))

    def _refuse(self, why: str) -> NoReturn:
        """Answer the set-up with why the stages cannot be made there, and wait for the run to end this."""
        while self._run.receive() is None:
            time.sleep(_LOOK_S)
        self._run.send(Frame(Kind.ANSWER, f"it cannot live on the host {self._name}: {why}"))
        while True:
            self._run.receive()
            time.sleep(_LOOK_S)


def _end_as(status: int) -> NoReturn:
    """End as the process on the host has ended, by the status that `subprocess` gives."""
    if status < 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if -status not in (signal.SIGKILL, signal.SIGSTOP):
            signal.signal(-status, signal.SIG_DFL)
        os.kill(os.getpid(), -status)
    os._exit(status)


def main() -> int:
    """Stand for a process until the run closes its side."""
    connection = connected(sys.argv[1], int(sys.argv[2]))
    if connection is None:
        return 1
    try:
        told = receive(connection).head
        caller = HostCaller(told["at"], told["port"], bytes.fromhex(told["key"]), SERVICE)
        join = told["join"]
        proxy = HostProxy(Link(connection), caller, join["host"], Frame(Kind.JOIN, join))
        signal.signal(signal.SIGINT, proxy.interrupt)
        proxy.serve()
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return 0
    except GraphnavError as error:
        print_notice(str(error))
        return 1


if __name__ == "__main__":
    sys.exit(main())
