"""End a run in which a call into a stage does not return."""

from __future__ import annotations

import faulthandler
import io
import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Self

from graphnav.core.errors import StageError
from graphnav.core.graph import Graph
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.runner.stage_calls import Call, StageCalls

_PERIOD_S = 0.5
_GRACE_S = 10.0
"""How much later than the limit the process is ended if not even this module's thread is run any more."""


@dataclass(frozen=True)
class StallLimit:
    """The longest time that one call into a stage may take, seconds of wall time.

    ``on_stall`` gets the summary when log and summary are written, and flushes what it prints; then the process ends
    with exit status 1: nothing else ends a call that does not return.
    """

    seconds: float
    on_stall: Callable[[Summary], None]


class StallWatch:
    """A context in which a thread ends the process after ``finish`` if a call into a stage takes too long.

    Time in which the process is suspended does not count. A native call that holds Python's interpreter lock stops this
    thread too: then `faulthandler` ends the process 10 s later and prints where it was, and no summary is written.
    """

    def __init__(self, calls: StageCalls, limit_s: float, finish: Callable[[Call], None]) -> None:
        self._calls, self._limit_s, self._finish = calls, limit_s, finish
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="graphnav stall", daemon=True)

    def __enter__(self) -> Self:
        self._arm()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        faulthandler.cancel_dump_traceback_later()

    def _serve(self) -> None:
        period_s = min(_PERIOD_S, self._limit_s / 4)
        seen: Call | None = None
        in_call_s = 0.0
        last_s = time.monotonic()
        while not self._ending.wait(period_s):
            self._arm()
            call, now_s = self._calls.current, time.monotonic()
            elapsed_s = now_s - last_s if call is seen else now_s - call[4] if call is not None else 0.0
            in_call_s = min(elapsed_s, 2 * period_s) + (in_call_s if call is seen else 0.0)
            seen, last_s = call, now_s
            if call is not None and in_call_s > self._limit_s and self._calls.hold(call):
                self._end(call)

    def _arm(self) -> None:
        """Let faulthandler end the process unless this thread defers it in time."""
        with suppress(ValueError, AttributeError, io.UnsupportedOperation):  # no file to write to
            faulthandler.dump_traceback_later(self._limit_s + _GRACE_S, exit=True, file=sys.__stderr__ or 2)

    def _end(self, call: Call) -> None:
        try:
            self._finish(call)
        finally:
            os._exit(1)


def stall_error(graph: Graph, call: Call, limit_s: float, start_utime: int = 0) -> StageError:
    """Return the error of a call that did not return: the stage, and what it was given."""
    name, method, utime, inputs, _ = call
    node = graph.node(name)
    given = [
        f"{link.port.name} of '{link.channel.ref}'"
        for link in node.inputs
        if link.channel is not None and _holds_something(inputs.get(link.port.name))
    ]
    what = f"{method} did not return within {limit_s:g} s of wall time" + (
        f"; given {', '.join(given)}" if given else ""
    )
    return StageError(name, node.use, (utime - start_utime) / 1e6, what)


def _holds_something(value: object) -> bool:
    """Whether an input of a step holds a message."""
    return value is not None and getattr(value, "message", value) is not None
