"""The full-screen spy among programs that invent channels and names."""

from __future__ import annotations

from pathlib import Path

from textual.pilot import Pilot

from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.messages import About, Twist
from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.channels_screen import ChannelTable

from .spy_app import drive, screen_text, until

HOSTILE = ["[red]markup[/red]", "esc\x1b[2J\x1b[31m", "[/]", "[@click=app.quit]x[/]", "bell\x07\x9b", "\u202eright"]


def test_hostile_names_are_shown_as_text(group: str, tmp_path: Path) -> None:
    async def act(pilot: Pilot[None]) -> None:
        bus = Bus(group)
        table = pilot.app.screen.query_one(ChannelTable)

        def published() -> bool:
            for name in HOSTILE:
                bus.publish(name, encode(About(name, name, name, 7, (name,), (name,)), 0, 0))
                bus.publish(About.CHANNEL, encode(About(name, name, name, 7, (name,), (name,)), 0, 0))
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
