"""``graphnav run`` as a program, and all processes that come of it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import uuid
from pathlib import Path

from tests.processes.conftest import STAGES, STEPS, processes_of, wait_until

PARTS = "deploy: {{left: {{stages: [clock, second]}}, right: {{stages: [third], {policy}}}}}"


class Command:
    """``graphnav run`` of the stages that count, in a process of its own, and the processes that come of it."""

    def __init__(self, folder: Path, third: str, policy: str = "restart: never") -> None:
        graph = folder / "steps.yaml"
        text = STEPS.format(deploy=PARTS.format(policy=policy), first="{}", third=third, more="")
        graph.write_text(text.replace("until_s: 3", "until_s: null").replace("n: 25", "n: 1000000"))
        self.folder, self._probe = folder / "run", uuid.uuid4().hex
        words = ["run", str(graph), "--plugin", str(STAGES), "-o", str(self.folder), "--no-tap", "--no-pictures"]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "graphnav", *words],
            env={**os.environ, "PROBE": self._probe},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    @property
    def others(self) -> list[int]:
        """All living processes that the command started, directly or not."""
        return [pid for pid in processes_of(self._probe) if pid != self.process.pid]

    @property
    def warden(self) -> int | None:
        """The living warden."""
        return next(filter(_is_warden, self.others), None)

    def gone_after_s(self) -> float:
        """Wait until no process is left; return how long that took."""
        begin_s = time.monotonic()
        wait_until(lambda: not self.others)
        return time.monotonic() - begin_s

    def kill(self) -> None:
        """Kill the command alone."""
        self.process.kill()
        self.process.wait()


def _is_warden(pid: int) -> bool:
    try:
        return b"warden.py" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:  # it has just ended
        return False
