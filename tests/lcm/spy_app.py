"""The full-screen spy without a terminal, a log for it, and a run that it can watch."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from textual.pilot import Pilot

from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode, lcm_name
from graphnav.core.messages import About, Flow, Image, Message, Plane, State, Twist
from graphnav.core.record import LogWriter
from graphnav.watch.feed import Feed
from graphnav.watch.spy.screen import SpyApp, watch_of
from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.channels_screen import ChannelTable
from graphnav.watch.spy.screen.screen_image import cells_of

TYPES: dict[str, type[Message]] = {
    "robot.image": Image,
    "flow.flow": Flow,
    "plane.plane": Plane,
    "control.twist": Twist,
    "robot.state": State,
}
SAID = About("stages: {}\n", "", "run-a", 7, tuple(TYPES), tuple(lcm_name(m.lcm_class) for m in TYPES.values()))
PERIOD_US = 100_000

Act = Callable[[Pilot[None]], Awaitable[None]]


def message_at(name: str, k: int) -> Message:
    """Return the k-th message of a channel."""
    pixels = np.full((12, 16), 10 * k % 256, np.uint8)
    valid = np.ones_like(pixels)
    if name == "robot.image":
        return Image(pixels)
    if name == "flow.flow":
        return Flow(np.full((12, 16, 2), 0.1 * k, np.float32), valid, PERIOD_US)
    if name == "plane.plane":
        return Plane(valid, valid.astype(np.float32), valid, 1, 1.0)
    if name == "control.twist":
        return Twist(0.1 * k, math.sin(k))
    return State(k, -k, 0.0, 0.1, 0.0, 1.0, contact=False, at_goal=False, moving=np.zeros((0, 3)))


def drive(feed: str, act: Act, size: tuple[int, int] = (200, 50), folder: Path | None = None) -> None:
    """Run the app on a feed without a terminal, and do something to it."""

    async def body() -> None:
        watch = watch_of(Feed(feed))
        watch.start()
        try:
            app = SpyApp(watch, Catalog(), folder or Path.cwd())
            async with app.run_test(size=size, notifications=True) as pilot:
                await act(pilot)
        finally:
            watch.close()

    asyncio.run(body())


async def until(pilot: Pilot[None], condition: Callable[[], object]) -> None:
    """Let the app go on until a condition holds."""
    for _ in range(600):
        if condition():
            return
        await pilot.pause(0.05)
    raise AssertionError(f"it never came to that:\n{screen_text(pilot)}")


def screen_text(pilot: Pilot[None]) -> str:
    """Return what stands on the screen."""
    screen = pilot.app.screen
    cells = [[" "] * screen.size.width for _ in range(screen.size.height)]
    for x, y, segment in cells_of(screen):
        for place, letter in enumerate(segment.text):
            if 0 <= y < len(cells) and x + place < len(cells[y]):
                cells[y][x + place] = letter
    return "\n".join("".join(line).rstrip() for line in cells)


def line_of(pilot: Pilot[None], name: str) -> str:
    """Return the table's line of a channel."""
    return next((line for line in screen_text(pilot).splitlines() if line.startswith(name)), "")


async def opened(pilot: Pilot[None], name: str) -> ChannelScreen:
    """Open a channel and return its screen."""
    await until(pilot, lambda: line_of(pilot, name))
    table = pilot.app.screen.query_one(ChannelTable)
    while table.chosen != name:
        await pilot.press("down" if table.cursor < table.n_shown - 1 else "home")
    await pilot.press("enter")
    await until(pilot, lambda: isinstance(pilot.app.screen, ChannelScreen))
    screen = pilot.app.screen
    assert isinstance(screen, ChannelScreen)
    return screen


def write_log(path: Path) -> Path:
    """Write a log of 20 messages at 10 Hz on each channel, two of the commands lost and one damaged."""
    with LogWriter(path) as writer:
        writer.write(About.CHANNEL, 0, encode(SAID, 0, 0))
        for k in range(20):
            for name in TYPES:
                data = encode(message_at(name, k), PERIOD_US * k, k)
                if name == "control.twist" and k in {5, 6, 9}:
                    if k == 9:
                        writer.write(name, PERIOD_US * k, data[:-1])
                    continue
                writer.write(name, PERIOD_US * k, data)
    return path


@contextmanager
def publishing(group: str, *names: str, run_id: str = "run-a", begin: int = 0) -> Iterator[None]:
    """Publish the channels from a thread, at 20 Hz, with the announcement of the run."""
    done = threading.Event()

    def publish() -> None:
        bus = Bus(group)
        k = begin
        while not done.wait(0.05):
            if k % 10 == 0:
                bus.publish(About.CHANNEL, encode(About("", "", run_id, 7, SAID.channels, SAID.types), 0, k // 10))
            for name in names:
                bus.publish(name, encode(message_at(name, k), PERIOD_US * k, k))
            k += 1
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
