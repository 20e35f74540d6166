"""Exit statuses of the command line."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """Statuses that ``main`` of a command returns, and the process with it."""

    OK = 0
    FAILED = 1
    USER_ERROR = 2
    INTERRUPTED = 130
    PIPE_CLOSED = 141
    """As shells report SIGPIPE: 128 + 13."""
