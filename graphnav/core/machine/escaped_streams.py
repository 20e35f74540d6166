"""Standard output and error through which text cannot act on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import IO, Any, TextIO, cast

from graphnav.core.errors import printable


class EscapedStream:
    """A stream of strings that writes what `printable` returns; ``unescaped``: the stream below it."""

    def __init__(self, unescaped: TextIO) -> None:
        self.unescaped = unescaped

    def __getattr__(self, name: str) -> Any:
        return getattr(self.unescaped, name)

    def write(self, text: str) -> int:
        """Write a string; return its length."""
        self.unescaped.write(printable(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write strings."""
        for line in lines:
            self.write(line)


@contextmanager
def escaped_output() -> Iterator[None]:
    """Replace standard output and error by streams that escape, for everything that prints inside."""
    old = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = map(_escaped, old)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = old


def unescaped(stream: IO[str]) -> IO[str]:
    """Return the stream below one that escapes, for escape sequences of our own; other text must be `printable`."""
    return stream.unescaped if isinstance(stream, EscapedStream) else stream


def _escaped(stream: TextIO | None) -> TextIO:
    """Return a stream that escapes; None, a stream that does not exist, stays None."""
    return cast("TextIO", stream if stream is None else EscapedStream(stream))
