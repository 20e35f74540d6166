"""The memory that a process has taken."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path


def forget_peak() -> None:
    """Let the peak of this process's memory begin again, where the system can."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def peak_mb(pid: int) -> float:
    """Return the peak of a process's resident memory so far, 0 of one that has ended.

    Not that of ``getrusage``, which begins with the memory of the process that has started it.
    """
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
    except OSError:
        return 0.0
    found = re.search(r"^VmHWM:\s+(\d+) kB", status, re.MULTILINE)
    return int(found[1]) / 1024 if found else 0.0
