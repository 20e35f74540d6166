"""The full-screen spy on logs: what it shows, and what its keys do."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot
from textual.widgets import Input

from graphnav.core.codec import encode
from graphnav.core.messages import About, Twist
from graphnav.core.record import LogWriter
from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.channels_screen import ChannelsScreen, ChannelTable
from graphnav.watch.spy.screen.field_tree import FieldTree
from graphnav.watch.spy.screen.keys_screen import KeysScreen
from graphnav.watch.spy.screen.picture_view import PictureView

from .spy_app import TYPES, drive, line_of, opened, screen_text, until, write_log

LOOKS = {"80x24": (80, 24), "200x50": (200, 50), "tiny": (20, 5)}


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of 20 messages at 10 Hz on each channel, two of the commands lost and one damaged."""
    return write_log(tmp_path / "run.lcmlog")


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


@pytest.mark.long
@pytest.mark.parametrize("look", LOOKS)
def test_channels_open_in_every_size(log: Path, look: str) -> None:
    opened = [*TYPES, About.CHANNEL] if look == "80x24" else [*list(TYPES)[::5], About.CHANNEL]

    async def act(pilot: Pilot[None]) -> None:
        table = pilot.app.screen.query_one(ChannelTable)
        await until(pilot, lambda: table.n_shown == len(TYPES) + 1)
        for name in opened:
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
        await until(pilot, lambda: "its first message is at 1.50 s" in screen_text(pilot))

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


@pytest.mark.parametrize("size", LOOKS.values(), ids=LOOKS)
def test_the_question_mark_shows_the_keys_of_the_screen(log: Path, size: tuple[int, int]) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: isinstance(pilot.app.screen, ChannelsScreen))
        await pilot.press("question_mark")
        await until(pilot, lambda: isinstance(pilot.app.screen, KeysScreen))
        if size[1] >= 24:
            await until(pilot, lambda: "sort by the next column" in screen_text(pilot))
            text = screen_text(pilot)
            assert "play the log, or pause" in text
            assert "freeze" not in text.partition("keys")[2].partition("closes")[0], "for live feeds alone"
        await pilot.press("question_mark")
        await until(pilot, lambda: isinstance(pilot.app.screen, ChannelsScreen))

    drive(str(log), act, size)


def test_at_40_columns_no_number_of_the_heading_is_cut_without_a_mark(log: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: line_of(pilot, "robot.state"))
        heading = screen_text(pilot).splitlines()[0]
        complete = pilot.app._session.heading().plain  # type: ignore[attr-defined]
        assert len(complete) > 40
        assert heading.endswith("…")
        assert complete.startswith(heading[:-1])
        assert "Hz" in line_of(pilot, "robot.state")

    drive(str(log), act, (40, 20))
