"""Handle Ctrl-C: end a run between two ticks, and interrupt a step that hangs."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self

from graphnav.core.interrupts import CtrlC

_PATIENCE_S = 0.5

Handler = Callable[[int, FrameType | None], None]


class Interrupt:
    """A context in which SIGINT, SIGTERM and SIGHUP ask the run to stop.

    A tick that does not end within half a second is interrupted by `CtrlC`, as it is by a second Ctrl-C.
    SIGHUP, which a closed terminal and then its shell may send, counts once, and not at all under ``nohup``. Outside
    the main thread, where Python delivers no signals, it does nothing. SIGALRM is its timer.
    """

    def __init__(self) -> None:
        self._asked = threading.Event()
        self._old: dict[int, Any] = {}
        self._handlers: dict[int, Handler] = {}

    @property
    def asked(self) -> bool:
        """Whether the user asked the run to stop."""
        return self._asked.is_set()

    def poll(self) -> bool:
        """Return whether the user asked the run to stop; take back signals that a stage has taken, as drivers do."""
        for number, handler in self._handlers.items():
            if signal.getsignal(number) != handler:
                signal.signal(number, handler)
        return self.asked

    def wait(self, seconds: float) -> None:
        """Sleep until the time has passed or the user asks to stop."""
        self._asked.wait(seconds)

    def settle(self) -> None:
        """Disarm the timeout: the run itself has ended. Another Ctrl-C still interrupts what follows."""
        if self._old:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._handlers = {signal.SIGALRM: self._run_out, signal.SIGINT: self._ask, signal.SIGTERM: self._ask}
            if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
                self._handlers[signal.SIGHUP] = self._ask
            self._old = {number: signal.signal(number, handler) for number, handler in self._handlers.items()}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._old:
            signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in self._old.items():
            signal.signal(number, handler)

    def _ask(self, number: int, _frame: FrameType | None) -> None:
        if self.asked:
            if number == signal.SIGHUP:
                return
            raise CtrlC
        self._asked.set()
        signal.setitimer(signal.ITIMER_REAL, _PATIENCE_S)

    def _run_out(self, _number: int, _frame: FrameType | None) -> None:
        if self.asked:  # otherwise it is the timer of a stage
            raise CtrlC
