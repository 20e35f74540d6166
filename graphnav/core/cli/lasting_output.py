"""Survive standard output or error being closed during a command, as by ``| head -1`` or with the terminal."""

from __future__ import annotations

import errno
import io
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any


@contextmanager
def lasting_output(*, for_a_reader: bool) -> Iterator[None]:
    """Discard output after the reader has left, so that the command still completes its other work.

    ``for_a_reader``: whether the command only prints; then a ReaderLeftError ends it.
    """
    old = sys.stdout, sys.stderr
    named = zip(old, ("standard output", "standard error"), strict=True)
    sys.stdout, sys.stderr = new = tuple(_lasting(*one, for_a_reader=for_a_reader) for one in named)
    try:
        yield
    finally:
        for stream in filter(None, new):
            with suppress(OSError):  # reported when it was printed
                stream.flush()
        sys.stdout, sys.stderr = old


def _lasting(stream: Any, label: str, *, for_a_reader: bool) -> Any:
    """Return a stream to the same file; the stream itself if there is no file, as in a test."""
    try:
        raw = _LastingFile(stream.fileno(), label, for_a_reader=for_a_reader)
    except (AttributeError, io.UnsupportedOperation):
        return stream
    stream.flush()
    return io.TextIOWrapper(
        raw if stream.write_through else io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


class ReaderLeftError(OSError):
    """Nothing reads the output any more; not a BrokenPipeError, which rich would turn into exit status 1."""


class _LastingFile(io.FileIO):
    """A file that discards all output after the first failed write."""

    def __init__(self, fd: int, label: str, *, for_a_reader: bool) -> None:
        super().__init__(fd, "w", closefd=False)
        self._label = label
        self._for_a_reader = for_a_reader

    def write(self, data: Any) -> int:
        """Write bytes; raise the OSError of the first failure, except for a reader that has left."""
        try:
            return super().write(data)
        except OSError as error:
            is_closed_terminal = error.errno == errno.EIO and stat.S_ISCHR(os.fstat(self.fileno()).st_mode)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())  # for buffered output, and for child processes
            os.close(nowhere)
            if not (isinstance(error, BrokenPipeError) or is_closed_terminal):
                raise OSError(error.errno, error.strerror, self._label) from error
            if self._for_a_reader:
                raise ReaderLeftError from error
            return memoryview(data).nbytes
