"""Wait for calls of C code so that Ctrl-C is obeyed: Python handles signals between two steps of its main thread."""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import TypeVar

T = TypeVar("T")


def interruptible(call: Callable[[], T]) -> T:
    """Return what ``call`` returns, made in another thread, which is left behind if this one is interrupted.

    Raises
    ------
    BaseException
        What ``call`` raises.
    """
    outcome: SimpleQueue[tuple[bool, T | BaseException]] = SimpleQueue()

    def work() -> None:
        try:
            outcome.put((True, call()))
        except BaseException as error:  # noqa: BLE001 - raised again below
            outcome.put((False, error))

    threading.Thread(target=work, name="capture", daemon=True).start()
    is_ok, found = outcome.get()
    if not is_ok:
        assert isinstance(found, BaseException)
        raise found
    return found  # type: ignore[return-value]
