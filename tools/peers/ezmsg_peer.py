"""ezmsg: two units in processes of their own, messages by shared memory.

Large buffers: 128 of 1 MB in place of 32.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ezmsg.core as ez

from peers.protocol import Job, Listener, Pixels, main, pictures


@dataclass
class Picture:
    """A message: an array, as ezmsg's own messages hold one."""

    pixels: Pixels


class FolderSettings(ez.Settings):
    """Where the job is."""

    folder: str


class Sender(ez.Unit):
    """Sends the pictures of a job."""

    SETTINGS = FolderSettings
    OUTPUT = ez.OutputStream(Picture)

    @ez.publisher(OUTPUT)
    async def send(self) -> AsyncGenerator[Any, None]:
        """Send them; pauses leave the loop to ezmsg's own tasks."""
        folder = Path(self.SETTINGS.folder)
        await asyncio.sleep(1.0)
        for pixels in pictures(Job.read(folder), folder):
            yield self.OUTPUT, Picture(pixels)
            await asyncio.sleep(0)


class LargeSender(Sender):
    """A sender with large buffers."""

    OUTPUT = ez.OutputStream(Picture, num_buffers=128)

    @ez.publisher(OUTPUT)
    async def send(self) -> AsyncGenerator[Any, None]:
        """Send them."""
        async for _, message in super().send():
            yield self.OUTPUT, message


class Hearer(ez.Unit):
    """Counts them."""

    SETTINGS = FolderSettings
    INPUT = ez.InputStream(Picture)

    async def initialize(self) -> None:
        """Begin."""
        folder = Path(self.SETTINGS.folder)
        self.listener = Listener(Job.read(folder), folder)

    @ez.subscriber(INPUT)
    async def hear(self, message: Picture) -> None:
        """Count a picture, a view of the shared memory while this lasts."""
        self.listener.take(message.pixels)
        if self.listener.is_late:
            self.listener.finish()
            raise ez.NormalTermination


def both(job: Job, folder: Path) -> None:
    """Run both processes."""
    settings = FolderSettings(folder=str(folder))
    sender, hearer = (LargeSender if job.large else Sender)(settings), Hearer(settings)
    ez.run(
        SENDER=sender,
        HEARER=hearer,
        connections=((sender.OUTPUT, hearer.INPUT),),
        process_components=(sender, hearer),
    )


if __name__ == "__main__":
    main(both=both)
