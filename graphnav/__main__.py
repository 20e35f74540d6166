"""The command ``graphnav``, and ``python -m graphnav``."""

import sys

from graphnav.core.interrupts import end_at_interrupt
from graphnav.core.machine import end_despite_threads


def main() -> int:
    """Run the command line; Ctrl-C before a command begins, or after its end, ends the process without a traceback."""
    end_at_interrupt()
    from graphnav.core import cli  # noqa: PLC0415 - it takes time, in which Ctrl-C may come

    status = cli.main()
    end_despite_threads(status)
    return status


if __name__ == "__main__":
    sys.exit(main())
