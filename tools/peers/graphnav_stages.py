"""Stages that send and count the pictures of a job: what `peers.graphnav_peer` runs."""

from __future__ import annotations

import queue
import threading
import time
from itertools import chain
from pathlib import Path

import numpy as np

from graphnav import Finished, Image, LiveSource, Stage, hookimpl, param
from peers.protocol import Job, Listener, Pixels, await_ready, pictures, ready, stamp

FAMILY = "peer"


class Camera(LiveSource):
    """Publishes the pictures of a job as a thread delivers them, which waits until the one before has been taken."""

    folder: str = param("", doc="where the job is")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Begin."""
        self._pending: tuple[Pixels | None, float] | None = None
        self._delivered: queue.Queue[tuple[Pixels | None, float]] = queue.Queue(1)
        threading.Thread(target=self._deliver, daemon=True).start()

    def arrived_s(self) -> float | None:
        """Return when the newest picture came."""
        if self._pending is None and not self._delivered.empty():
            self._pending = self._delivered.get()
        return None if self._pending is None else self._pending[1]

    def step(self) -> Image:
        """Return it, with the time of now in it."""
        assert self._pending is not None
        (pixels, _), self._pending = self._pending, None
        if pixels is None:
            raise Finished("end")
        stamp(pixels)
        return Image(pixels=pixels)

    def _deliver(self) -> None:
        folder = Path(self.folder)
        await_ready(folder)
        for pixels in chain(pictures(Job.read(folder), folder), [None]):
            self._delivered.put((pixels, time.monotonic()))
            self.wake()


class Hear(Stage):
    """Counts the pictures that arrive."""

    folder: str = param("", doc="where the job is")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Begin."""
        folder = Path(self.folder)
        self._listener = Listener(Job.read(folder), folder)
        ready(folder)

    def step(self, image: Image) -> None:
        """Count a picture."""
        self._listener.take(np.asarray(image.pixels))
        if self._listener.is_over:
            self._listener.finish()

    def close(self) -> None:
        """Note what has arrived."""
        self._listener.finish()


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return them."""
    return [Camera, Hear]
