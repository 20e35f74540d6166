"""Exit statuses of the command line."""

OK = 0
FAILED = 1
USER_ERROR = 2
INTERRUPTED = 130
PIPE_CLOSED = 141
"""Exit status that shells report for SIGPIPE: 128 + 13."""
