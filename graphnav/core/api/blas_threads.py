"""Limit BLAS to one thread during a run: thread counts change sums, and the same seed must give the same log."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from threadpoolctl import OpenBLASController, ThreadpoolController


class _BlasLimit:
    """The process-wide limit of BLAS threads, in force during any run in any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._n_runs = 0
        self._limits: list[Any] = []

    def enter(self) -> None:
        """Limit the libraries loaded so far."""
        with self._lock:
            _take_control()
            self._n_runs += 1
            self._limits.append(_limited("blas"))

    def leave(self) -> None:
        """Remove all limits, newest first, if this was the last run."""
        with self._lock:
            self._n_runs -= 1
            if not self._n_runs:
                _take_control()
                while self._limits:
                    self._limits.pop().restore_original_limits()
                _take_control()


_blas = _BlasLimit()


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the loaded libraries to one thread each; OpenMP only for the calling thread."""
    with _limited("openmp"), one_blas_thread():
        yield


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS to one thread; OpenMP, by which learners compute, keeps its own."""
    _blas.enter()
    try:
        yield
    finally:
        _blas.leave()


def _limited(kind: str) -> Any:
    """Return a limit of the libraries of one kind only."""
    return ThreadpoolController().select(user_api=kind).limit(limits=1)


def _take_control() -> None:
    """Let the calling thread set limits: newer versions of threadpoolctl allow it only to the first such thread."""
    clear = getattr(OpenBLASController, "clear_controlling_thread", None)
    if clear is not None:
        clear(force=True)
