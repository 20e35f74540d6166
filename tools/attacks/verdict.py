"""How a command may come out of a hostile input."""

from __future__ import annotations

import re
from typing import NamedTuple

STATUSES = (0, 1, 2)
MAX_S = 10.0
MAX_MB = 500.0
MAX_CHECK_S, MAX_CHECK_MB = 6.0, 300.0
"""Of ``check``, the time that its process was given by the processors: it takes 0.3 s to 1 s, more on a loaded one."""
_OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff]")
"""Characters that a terminal obeys or does not show; tabs and line breaks are layout."""
_TRACEBACK = "Traceback (most recent call last)"


class Outcome(NamedTuple):
    """The end of a command: its status, what it printed, its own time and the process's peak of memory until then.

    ``status``: None if it did not end; ``escaped``: an exception that it let out; ``cpu_s``: processor time, 0 if that
    was not measured.
    """

    status: int | None
    output: str
    elapsed_s: float
    peak_mb: float
    escaped: str = ""
    cpu_s: float = 0.0


def faults(outcome: Outcome, *, of_check: bool = False) -> list[str]:
    """Return what is wrong with an outcome, nothing if it is as it should be; ``of_check``: one of ``check``."""
    found = []
    if outcome.status is None:
        found.append(f"hangs: no end after {outcome.elapsed_s:.0f} s")
    elif outcome.escaped:
        found.append(f"lets out {outcome.escaped}")
    elif outcome.status not in STATUSES:
        found.append(f"exit status {outcome.status}")
    elif outcome.status and not outcome.output.strip():
        found.append(f"exit status {outcome.status} without a word")
    if _TRACEBACK in outcome.output:
        found.append("prints a traceback")
    if obeyed := _OBEYED.search(outcome.output):
        found.append(f"prints {obeyed[0]!a}, which a terminal obeys")
    if outcome.status is not None and outcome.elapsed_s > MAX_S:
        found.append(f"takes {outcome.elapsed_s:.0f} s")
    if of_check and outcome.cpu_s > MAX_CHECK_S:
        found.append(f"takes {outcome.cpu_s:.1f} s of processor time")
    if outcome.peak_mb > (MAX_CHECK_MB if of_check else MAX_MB):
        found.append(f"takes {outcome.peak_mb:.0f} MB")
    return found
