"""A command line in a process of its own, with the peak of its memory."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from attacks.memory import peak_mb
from attacks.own_time import OwnTime
from attacks.python_door import DOOR
from attacks.verdict import MAX_S, Outcome

COMMAND = (sys.executable, "-m", "graphnav")
TOOLS = Path(__file__).resolve().parents[1]
_WAIT_S = 3 * MAX_S
_LOOK_S = 0.02


def command_line(words: Sequence[str]) -> list[str]:
    """Return what runs a command of graphnav, or a door of the package, in a process of its own."""
    if words[0] == DOOR:
        return [sys.executable, "-m", "attacks.python_door", *words[1:]]
    return [*COMMAND, *words]


def outcome_of(
    words: Sequence[str], *, folder: Path | None = None, environment: Mapping[str, str] = os.environ
) -> Outcome:
    """Run a command line in a folder; it is killed if it has not ended after three times the limit of `MAX_S`."""
    peak = 0.0
    with tempfile.TemporaryFile() as printed:
        process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=printed,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env={**environment, "PYTHONPATH": str(TOOLS)},
        )
        own_time, elapsed_s = OwnTime(process.pid), 0.0
        while process.poll() is None and (elapsed_s := own_time.elapsed_s()) < _WAIT_S:
            peak = max(peak, peak_mb(process.pid))
            time.sleep(_LOOK_S)
        status = process.poll()
        process.kill()
        process.wait()
        printed.seek(0)
        output = printed.read().decode("utf-8", "replace")
    return Outcome(status, output, elapsed_s, peak)
