"""Ctrl-C, SIGTERM and SIGHUP by the user, told from what a plugin raises.

What they do depends on what there is to save:

- `end_at_interrupt`, while a command starts and when it is done: nothing, so that they end the process at once.
- `raise_at_interrupt`, while a command works: they raise `CtrlC`, and its context managers remove what is incomplete.
- `Interrupt`, during a run or a recording: they ask for the end, so that log and summary are complete.

Python functions that are called by another program handle SIGINT alone, and leave a handler that is not Python's own.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import Any, ClassVar, Self

_HANG_UP: signal.Signals = signal.SIGHUP if hasattr(signal, "SIGHUP") else getattr(signal, "SIGBREAK")  # noqa: B009
"""Windows has SIGBREAK in place of SIGHUP: for Ctrl-Break, and when the console is closed."""
_SIGNALS = (signal.SIGINT, signal.SIGTERM, _HANG_UP)
_HAS_TIMER = hasattr(signal, "setitimer")
_INTERRUPTED = 130
_STDERR = 2
_PATIENCE_S = 0.5
_AGAIN_S = 0.02


class CtrlC(KeyboardInterrupt):
    """The user ends the program by a signal; a plain KeyboardInterrupt out of a plugin is an error of the plugin."""

    n_raised: ClassVar[int] = 0
    """How often it was raised: what another exception was made of it in the meantime is known by that."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__()
        self.number = number
        CtrlC.n_raised += 1


def raise_ctrl_c(number: int = signal.SIGINT, _frame: FrameType | None = None) -> None:
    """Raise `CtrlC`; a signal handler."""
    raise CtrlC(number)


def end_at_interrupt() -> None:
    """Let Ctrl-C, SIGTERM and SIGHUP end the process at once, unless they are ignored or handled otherwise.

    An exception would not do: within an import it may be printed and lost, or turned into an ImportError.
    """
    if not _is_main_thread():
        return
    if signal.getsignal(signal.SIGINT) in {signal.default_int_handler, raise_ctrl_c}:
        signal.signal(signal.SIGINT, _end)
    for number in (signal.SIGTERM, _HANG_UP):
        if signal.getsignal(number) is raise_ctrl_c:
            signal.signal(number, signal.SIG_DFL)


def raise_at_interrupt() -> None:
    """Let Ctrl-C, SIGTERM and SIGHUP raise `CtrlC` after `end_at_interrupt`."""
    if not _is_main_thread():
        return
    for number, before in zip(_SIGNALS, (_end, signal.SIG_DFL, signal.SIG_DFL), strict=True):
        if signal.getsignal(number) == before:
            signal.signal(number, raise_ctrl_c)


@contextmanager
def ended_by_interrupt(*, owns_process: bool) -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and SIGHUP end the process at once in the block, if the process is the command's own."""
    if not owns_process:
        yield
        return
    end_at_interrupt()
    try:
        yield
    finally:
        raise_at_interrupt()


@contextmanager
def ctrl_c_not_lost() -> Iterator[None]:
    """Send the signal again whose `CtrlC` had no caller, as that of a destructor, instead of printing a traceback."""
    usual = sys.unraisablehook

    def send_again(lost: sys.UnraisableHookArgs) -> None:
        if not isinstance(lost.exc_value, CtrlC):
            usual(lost)
            return
        timer = threading.Timer(_AGAIN_S, _send_to_main, [lost.exc_value.number])
        timer.daemon = True
        try:
            timer.start()
        except CtrlC:  # already, on a busy machine: lost here, too
            send_again(lost)

    sys.unraisablehook = send_again
    try:
        yield
    finally:
        sys.unraisablehook = usual


@contextmanager
def ctrl_c_prevails() -> Iterator[None]:
    """Raise `CtrlC` after a block in which it was raised, whatever became of it.

    Compiled modules turn it into an ImportError, which the modules that import them may catch.
    """
    before = CtrlC.n_raised
    try:
        yield
    except CtrlC:
        raise
    except BaseException as error:
        if CtrlC.n_raised != before:
            raise CtrlC from error
        raise
    if CtrlC.n_raised != before:
        raise CtrlC


@contextmanager
def ctrl_c_later() -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP wait for the end of the block, so that it makes its objects completely.

    Windows has no mask of signals: there they do not wait.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def plain_ctrl_c() -> Iterator[None]:
    """Let SIGINT raise a KeyboardInterrupt in the block, which asyncio then turns into the end of its task."""
    if signal.getsignal(signal.SIGINT) is not raise_ctrl_c:
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, raise_ctrl_c)


@contextmanager
def third_party_code() -> Iterator[None]:
    """Run code of a plugin outside of a run: Ctrl-C raises `CtrlC` in it, and out of it, and it stays in its folder."""
    is_pythons = _is_main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if is_pythons:
        signal.signal(signal.SIGINT, raise_ctrl_c)
    try:
        with working_folder_restored(), ctrl_c_prevails():
            yield
    finally:
        if is_pythons:
            signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def working_folder_restored() -> Iterator[None]:
    """Restore the working folder afterwards, so that relative paths mean what the user wrote."""
    try:
        folder = os.getcwd()
    except OSError:  # it was removed
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            os.chdir(folder)


class Interrupt:
    """A context in which SIGINT, SIGTERM and SIGHUP ask the run to stop.

    A tick that does not end within half a second is interrupted by `CtrlC`, as it is by a second Ctrl-C.
    SIGHUP, which a closed terminal and then its shell may send, counts once, and not at all under ``nohup``. Outside
    the main thread, where Python delivers no signals, it does nothing. SIGALRM is its timer, on Windows a thread.
    """

    def __init__(self) -> None:
        self.asked = False
        """Whether the user asked the run to stop."""
        self._released = threading.Lock()
        """Held until then. Not an event: a signal that comes while `wait` holds the lock of one would never return."""
        self._released.acquire()
        self._old: dict[int, Any] = {}
        self._timer: threading.Timer | None = None

    def wait(self, seconds: float) -> None:
        """Sleep until the time has passed or the user asks to stop."""
        if self._released.acquire(timeout=max(0.0, seconds)):
            self._released.release()

    def settle(self) -> None:
        """Disarm the timeout: the run itself has ended. Another Ctrl-C still interrupts what follows."""
        if self._old and _HAS_TIMER:
            signal.setitimer(signal.ITIMER_REAL, 0)
        elif self._timer is not None:
            self._timer.cancel()

    def __enter__(self) -> Self:
        if _is_main_thread():
            is_kept = signal.getsignal(_HANG_UP) == signal.SIG_IGN
            alarm = (signal.SIGALRM,) if _HAS_TIMER else ()
            numbers = (*alarm, signal.SIGINT, signal.SIGTERM, *(() if is_kept else (_HANG_UP,)))
            self._old = {number: signal.signal(number, self._ask) for number in numbers}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.settle()
        for number, handler in self._old.items():
            signal.signal(number, handler)

    def _ask(self, number: int, _frame: FrameType | None) -> None:
        if not self.asked:
            self.asked = True
            self._released.release()
            self._set_timer()
        elif number != _HANG_UP:
            raise CtrlC

    def _set_timer(self) -> None:
        if _HAS_TIMER:
            signal.setitimer(signal.ITIMER_REAL, _PATIENCE_S)
            return
        self._timer = threading.Timer(_PATIENCE_S, _send_to_main, [signal.SIGINT])
        self._timer.daemon = True
        self._timer.start()


def _send_to_main(number: int) -> None:
    """Send a signal to the main thread; where threads can be sent one it also interrupts what is waited for."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        signal.raise_signal(number)


def _is_main_thread() -> bool:
    """Whether this thread may handle signals: Python delivers them to no other one."""
    return threading.current_thread() is threading.main_thread()


def _end(*_: object) -> None:
    try:
        os.write(_STDERR, b"stopped\n")
    finally:
        os._exit(_INTERRUPTED)
