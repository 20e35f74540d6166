"""``graphnav record`` in a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sysconfig
import threading
import time
from collections.abc import Callable
from pathlib import Path

from graphnav.core.bus import Bus
from graphnav.core.errors import LogError
from graphnav.core.record import Event, Recording

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
PATIENCE_S = 60


def wait_until(is_so: Callable[[], bool]) -> None:
    """Wait for a condition."""
    end_s = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def events_of(path: Path) -> list[Event]:
    """Return the complete events of a log that may still grow, or not be there yet."""
    if not path.exists():
        return []
    try:
        with Recording(path) as recording:
            return list(recording.events())
    except LogError:
        return []


class RecordProcess:
    """A process that records; ``bus`` publishes to it."""

    def __init__(self, url: str, path: Path, *options: str) -> None:
        self.path = path
        self.bus = Bus(url)
        self.process = subprocess.Popen(
            [GRAPHNAV, "record", url, "-o", str(path), *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "COLUMNS": "160"},
        )
        assert self.process.stdout is not None
        self.announced = self.process.stdout.readline()

    def publish_until_heard(self, channel: str = "mark") -> None:
        """Publish until something is in the log."""
        over = threading.Event()

        def publish() -> None:
            while not over.wait(0.02):
                self.bus.publish(channel, b"")

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            wait_until(lambda: self.process.poll() is not None or len(events_of(self.path)) > 0)
        finally:
            over.set()
            thread.join()

    def end(self, number: int = signal.SIGINT) -> tuple[int, str, str]:
        """Send a signal; return the exit status, standard output and standard error."""
        self.process.send_signal(number)
        out, err = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out, err

    def close(self) -> None:
        """End what still runs."""
        self.process.kill()
        self.process.communicate()
        self.bus.close()
