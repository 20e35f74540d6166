"""The errors that a run met, each once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from graphnav.core.errors import GraphnavError


class Failures:
    """Collects what went wrong in a run and while it ended; ``on_failure`` gets every error as it is met."""

    def __init__(self, on_failure: Callable[[GraphnavError], None]) -> None:
        self._on_failure = on_failure
        self._found: list[GraphnavError] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Let an error end the block, not the run's record."""
        try:
            yield
        except GraphnavError as error:
            if not any(error is one for one in self._found):  # a log that failed says so again when it is closed
                self._found.append(error)
                self._on_failure(error)

    def close(self, close: Callable[[], None]) -> None:
        """Close something."""
        with self.noted():
            close()

    def __bool__(self) -> bool:
        return bool(self._found)

    @property
    def cause(self) -> str:
        """The causes of all failures without their times, one per line."""
        return "\n".join(error.cause for error in self._found)

    def __str__(self) -> str:
        return "\n".join(map(str, self._found))
