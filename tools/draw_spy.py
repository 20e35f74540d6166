"""Draw ``docs/spy.svg``: the full-screen spy on the log of a drive, with a dominant plane open."""

from __future__ import annotations

import asyncio
import re
import subprocess
import sysconfig
import tempfile
from contextlib import chdir
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.watch.feed import Feed
from graphnav.watch.spy.screen import SpyApp, watch_of
from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.channels_screen import ChannelTable

ROOT = Path(__file__).resolve().parents[1]
GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
TARGET = ROOT / "docs" / "spy.svg"
_SIZE = (120, 36)
_CHANNEL = "plane.plane"
_PAUSE_S = 0.5
_WEB_FONT = re.compile(r"\s*@font-face \{.*?\}", re.DOTALL)
"""A picture that loads nothing."""


async def draw(log: str, target: Path) -> None:
    """Open the channel at the end of the log and save the screen."""
    watch = watch_of(Feed(log))
    watch.start()
    try:
        app = SpyApp(watch, Catalog(), ROOT)
        async with app.run_test(size=_SIZE) as pilot:
            table = app.screen.query_one(ChannelTable)
            while table.chosen != _CHANNEL:
                await pilot.press("down" if table.cursor < table.n_shown - 1 else "home")
            await pilot.press("enter", "down", "down", "down")
            while not isinstance(app.screen, ChannelScreen) or app.screen.picture is None:
                await pilot.pause(_PAUSE_S)
            await pilot.pause(2 * _PAUSE_S)
            drawing = app.export_screenshot(title="graphnav spy", simplify=True)
            target.write_text(_WEB_FONT.sub("", drawing), encoding="utf-8")
    finally:
        watch.close()


def main() -> None:
    """Drive, then draw."""
    with tempfile.TemporaryDirectory() as folder:
        command = [GRAPHNAV, "run", "corridor_ccw", "--tap", "none", "--until", "17", "-o", "corridor_ccw"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=folder)
        with chdir(folder):
            asyncio.run(draw("corridor_ccw", TARGET))


if __name__ == "__main__":
    main()
