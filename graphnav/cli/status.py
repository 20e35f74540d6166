"""Exit statuses of the command line."""

OK = 0
FAILED = 1
USER_ERROR = 2
INTERRUPTED = 130
