"""The full-screen spy: what it shows of logs and of live channels, and what its keys do."""

from __future__ import annotations

import asyncio
import math
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input, Static

from graphnav.bus import Bus
from graphnav.catalog import Catalog
from graphnav.codec import encode, lcm_name
from graphnav.messages import About, Flow, Image, Message, Plane, State, Twist
from graphnav.record import ABOUT, LogWriter, Recording
from graphnav.spy import Feed
from graphnav.spy.screen import SpyApp, watch_of
from graphnav.spy.screen.channel_screen import ChannelScreen
from graphnav.spy.screen.channel_table import ChannelTable
from graphnav.spy.screen.channels_screen import ChannelsScreen
from graphnav.spy.screen.field_tree import FieldTree
from graphnav.spy.screen.picture_view import PictureView

TYPES: dict[str, type[Message]] = {
    "robot.image": Image,
    "flow.flow": Flow,
    "plane.plane": Plane,
    "control.twist": Twist,
    "robot.state": State,
}
SAID = About("stages: {}\n", "", "run-a", 7, tuple(TYPES), tuple(lcm_name(m.lcm_class) for m in TYPES.values()))
LOOKS = {"80x24": (80, 24), "200x50": (200, 50), "tiny": (20, 5)}
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


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of 20 messages at 10 Hz on each channel, two of the commands lost and one damaged."""
    path = tmp_path / "run.lcmlog"
    with LogWriter(path) as writer:
        writer.write(ABOUT, 0, encode(SAID, 0, 0))
        for k in range(20):
            for name in TYPES:
                data = encode(message_at(name, k), PERIOD_US * k, k)
                if name == "control.twist" and k in {5, 6, 9}:
                    if k == 9:
                        writer.write(name, PERIOD_US * k, data[:-1])
                    continue
                writer.write(name, PERIOD_US * k, data)
    return path


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
    from graphnav.spy.screen.screen_image import cells_of

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


def test_a_log_fills_the_table(log: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: "10.00 Hz" in line_of(pilot, "robot.state"))
        line = line_of(pilot, "control.twist").split()
        assert line[:4] == ["control.twist", "graphnav_lcm.twist_t", "18", "10.00"]
        text = screen_text(pilot)
        assert "3" in line  # drops: two were never written, one is damaged and has no number
        assert "at 1.90 of 1.90 s" in text
        assert "undec." in text

    drive(str(log), act)


@pytest.mark.parametrize("look", LOOKS)
def test_every_channel_opens_in_every_size(log: Path, look: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        table = pilot.app.screen.query_one(ChannelTable)
        await until(pilot, lambda: table.n_shown == len(TYPES) + 1)
        for name in [*TYPES, ABOUT]:
            while table.chosen != name:
                await pilot.press("down" if table.cursor < table.n_shown - 1 else "home")
            await pilot.press("enter", "v", "v", "v", "p", "enter", "down")
            assert isinstance(pilot.app.screen, ChannelScreen)
            await pilot.press("escape")
            assert isinstance(pilot.app.screen, ChannelsScreen)

    drive(str(log), act, LOOKS[look])


def test_a_channel_shows_fields_picture_and_plot(log: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        screen = await opened(pilot, "robot.image")
        await until(pilot, lambda: screen.picture is not None)
        assert np.abs(screen.picture.astype(int) - 190).max() == 0  # type: ignore[union-attr]
        await until(pilot, lambda: "uint8 (192)" in screen_text(pilot))
        await pilot.press("escape")
        screen = await opened(pilot, "control.twist")
        await until(pilot, lambda: "v_mps 1.9" in screen_text(pilot))
        assert not screen.query_one(PictureView).display
        assert "⠤" in screen_text(pilot) or "⠉" in screen_text(pilot)

    drive(str(log), act)


def shows(screen: ChannelScreen, level: int) -> bool:
    """Return whether a screen's picture is of a gray level."""
    return screen.picture is not None and bool(screen.picture[0, 0, 0] == level)


def test_a_log_is_stepped_through(log: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        screen = await opened(pilot, "robot.image")
        await until(pilot, lambda: screen.picture is not None)
        for key, level in (("comma", 180), ("comma", 170), ("full_stop", 180), ("less_than_sign", 80)):
            await pilot.press(key)
            await until(pilot, partial(shows, screen, level))
        await pilot.press("space")
        await until(pilot, lambda: "PLAYING" in screen_text(pilot))
        await until(pilot, lambda: "at 1.90 of" in screen_text(pilot) and "PLAYING" not in screen_text(pilot))

    drive(str(log), act)


def test_before_its_first_message_a_channel_says_when_it_comes(tmp_path: Path) -> None:
    path = tmp_path / "late.lcmlog"
    with LogWriter(path) as writer:
        writer.write("a", 0, encode(Twist(0, 0), 0, 0))
        writer.write("b", 1_500_000, encode(Twist(0, 0), 0, 0))

    async def act(pilot: Pilot[None]) -> None:
        await opened(pilot, "b")
        await pilot.press("less_than_sign")
        await until(pilot, lambda: "its first message comes at 1.50 s" in screen_text(pilot))

    drive(str(path), act)


def test_arrays_expand_and_fields_are_plotted(log: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        screen = await opened(pilot, "flow.flow")
        tree = screen.query_one(FieldTree)
        await until(pilot, lambda: tree.chosen is not None)
        while tree.chosen is not None and tree.chosen.name != "uv_px":
            await pilot.press("down")
        await pilot.press("enter", "down", "enter")
        await until(pilot, lambda: "[0]" in screen_text(pilot))
        await pilot.press("p")
        await until(pilot, lambda: "is not a number" in screen_text(pilot))
        await pilot.press("home", "down", "down", "p", "v", "v")
        await until(pilot, lambda: "• interval_us" in screen_text(pilot))

    drive(str(log), act)


def test_filter_and_sort(log: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        table = pilot.app.screen.query_one(ChannelTable)
        await until(pilot, lambda: table.n_shown == len(TYPES) + 1)
        await pilot.press("slash", *"ROBOT", "enter")
        assert table.n_shown == 2
        await pilot.press("slash", *"zzz")
        assert table.n_shown == 0
        await until(pilot, lambda: "Esc shows all" in screen_text(pilot))
        await pilot.press("escape")
        assert table.n_shown == len(TYPES) + 1
        assert not pilot.app.screen.query_one(Input).display
        await pilot.press("home")
        assert table.chosen == "control.twist"
        while table.sort_by.heading != "size":
            await pilot.press("s")
        await pilot.press("home")
        assert table.chosen == "flow.flow"
        await pilot.press("S", "home")
        assert table.chosen == "control.twist"

    drive(str(log), act)


def test_what_is_seen_is_saved(log: Path, tmp_path: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: line_of(pilot, "robot.state"))
        await pilot.press("w")
        screen = await opened(pilot, "robot.image")
        await until(pilot, lambda: screen.picture is not None)
        await pilot.press("w")
        await until(pilot, lambda: len(list(tmp_path.glob("*.png"))) == 2)

    drive(str(log), act, folder=tmp_path)
    from PIL import Image as PilImage

    for path in tmp_path.glob("spy-*.png"):
        with PilImage.open(path) as image:
            assert image.size == (2000, 1000)


def test_a_folder_that_takes_nothing_is_said(log: Path, tmp_path: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: line_of(pilot, "robot.state"))
        await pilot.press("w")
        await until(pilot, lambda: "cannot save" in screen_text(pilot))

    drive(str(log), act, folder=tmp_path / "missing")


# --- live -----------------------------------------------------------------------------------------------------------


@contextmanager
def publishing(group: str, *names: str, run_id: str = "run-a", begin: int = 0) -> Iterator[None]:
    """Publish the channels from a thread, at 20 Hz, with the announcement of the run."""
    done = threading.Event()

    def publish() -> None:
        bus = Bus(group)
        k = begin
        while not done.wait(0.05):
            if k % 10 == 0:
                bus.publish(ABOUT, encode(About("", "", run_id, 7, SAID.channels, SAID.types), 0, k // 10))
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


def test_it_starts_before_the_publishers_and_outlives_them(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: "no publisher" in screen_text(pilot))
        with publishing(group, "robot.image", "control.twist"):
            await until(pilot, lambda: "Hz" in line_of(pilot, "control.twist"))
            assert "no publisher" not in screen_text(pilot)
            screen = await opened(pilot, "robot.image")
            await until(pilot, lambda: screen.picture is not None)
        await until(pilot, lambda: "stale for" in screen_text(pilot))
        assert screen.picture is not None
        with publishing(group, "robot.image", run_id="run-b"):
            await until(pilot, lambda: "run run-b" in screen_text(pilot))
            await until(pilot, lambda: "stale for" not in screen_text(pilot))

    drive(group, act)


def test_what_was_announced_and_does_not_come_says_so(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist"):
            await opened(pilot, "flow.flow")
            await until(pilot, lambda: "announced, and not heard" in screen_text(pilot))

    drive(group, act)


def test_an_unknown_type_says_its_fingerprint(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        bus = Bus(group)

        def published() -> bool:
            bus.publish("strange", b"\x01\x23\x45\x67\x89\xab\xcd\xefmore")
            return bool(line_of(pilot, "strange"))

        await until(pilot, published)
        await opened(pilot, "strange")
        await until(pilot, lambda: "unknown fingerprint 0123456789abcdef" in screen_text(pilot))
        bus.close()

    drive(group, act)


def test_frozen_the_view_stands_still_and_nothing_is_missed(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist"):
            await opened(pilot, "control.twist")
            await until(pilot, lambda: "v_mps" in screen_text(pilot))
            await pilot.press("space")
            await until(pilot, lambda: "FROZEN" in screen_text(pilot))
            watch = pilot.app._session.watch  # type: ignore[attr-defined]
            channel, seen = watch.channel("control.twist"), body_of(pilot)
            count = channel.count
            await until(pilot, lambda: channel.count > count + 10)
            assert body_of(pilot) == seen
            await pilot.press("space")
            await until(pilot, lambda: body_of(pilot) != seen)
            assert channel.lost == 0

    drive(group, act)


def body_of(pilot: Pilot[None]) -> str:
    """Return the screen below its heading."""
    return "\n".join(screen_text(pilot).splitlines()[1:])


def test_what_is_heard_is_recorded(group: str, tmp_path: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        with publishing(group, "control.twist", "robot.image"):
            await until(pilot, lambda: "Hz" in line_of(pilot, "control.twist"))
            await pilot.press("r")
            await until(pilot, lambda: "recording spy-" in screen_text(pilot))
            path = next(tmp_path.glob("spy-*.lcmlog"))
            channel = pilot.app._session.watch.channel("control.twist")  # type: ignore[attr-defined]
            count = channel.count
            await until(pilot, lambda: channel.count > count + 10)
            await pilot.press("r")
            await until(pilot, lambda: "recording spy-" not in screen_text(pilot))
        with Recording(path) as recording:
            assert recording.about is not None
            assert recording.about.run_id == "run-a"
            assert recording.count("control.twist") >= 10
            assert recording.count("robot.image") >= 10

    drive(group, act, folder=tmp_path)


HOSTILE = ["[red]markup[/red]", "esc\x1b[2J\x1b[31m", "[/]", "[@click=app.quit]x[/]", "bell\x07\x9b", "\u202eright"]


def test_hostile_names_are_shown_as_text(group: str, tmp_path: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        bus = Bus(group)
        table = pilot.app.screen.query_one(ChannelTable)

        def published() -> bool:
            for name in HOSTILE:
                bus.publish(name, encode(About(name, name, name, 7, (name,), (name,)), 0, 0))
                bus.publish(ABOUT, encode(About(name, name, name, 7, (name,), (name,)), 0, 0))
            return table.n_shown > len(HOSTILE)

        await until(pilot, published)
        await until(pilot, lambda: "[red]markup[/red]" in screen_text(pilot))
        assert all(line.isprintable() for line in screen_text(pilot).splitlines())
        for _ in range(len(HOSTILE)):
            await pilot.press("down", "enter", "enter")
            assert isinstance(pilot.app.screen, ChannelScreen)
            assert all(line.isprintable() for line in screen_text(pilot).splitlines())
            await pilot.press("w", "escape")
        await pilot.press("slash", *"[red]")
        assert table.n_shown == 1
        bus.close()

    drive(group, act, folder=tmp_path)


def test_invented_channels_are_counted_and_not_kept(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        bus = Bus(group)
        numbers = iter(range(10**9))

        def published() -> bool:
            for _ in range(50):
                bus.publish(f"c{next(numbers)}", encode(Twist(0, 0), 0, 0))
            return "of further channels not kept" in screen_text(pilot)

        await until(pilot, published)
        assert "512 channels" in screen_text(pilot)
        bus.close()

    drive(group, act)


def test_heading_says_where_it_listens(group: str) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: group in str(pilot.app.screen.query_one("#heading", Static).render()))

    drive(group, act)
