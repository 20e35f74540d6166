"""The full-screen spy."""

from __future__ import annotations

import asyncio
import re
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType
from typing import ClassVar

from rich.cells import cell_len, set_cell_size
from rich.segment import Segment
from textual.app import App
from textual.binding import Binding, BindingType
from textual.color import Color
from textual.filter import LineFilter

from graphnav.core.catalog import Catalog
from graphnav.core.errors import printable
from graphnav.core.interrupts import plain_ctrl_c
from graphnav.watch.spy.live_watch import LiveWatch
from graphnav.watch.spy.log_watch import LogWatch
from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.channels_screen import ChannelsScreen
from graphnav.watch.spy.screen.keys_screen import KeysScreen
from graphnav.watch.spy.screen.painters.block_painter import BlockPainter
from graphnav.watch.spy.screen.painters.painter import Painter
from graphnav.watch.spy.screen.picture_view import PictureView
from graphnav.watch.spy.screen.screen_image import screen_image
from graphnav.watch.spy.screen.session import Session
from graphnav.watch.spy.screen.terminal_driver import TerminalDriver

_TICK_S = 0.1
_LIVE_ONLY = {"freeze", "record"}
_LOG_ONLY = {"play", "step", "skip"}


class EscapeFilter(LineFilter):
    """Escapes the text of a line and keeps its width; pictures as escape sequences do not pass through filters."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Return the segments of a line."""
        del background
        return [segment if segment.control else _escaped(segment) for segment in segments]


def _escaped(segment: Segment) -> Segment:
    text = printable(segment.text)
    if text == segment.text:
        return segment
    return Segment(set_cell_size(text, cell_len(segment.text)), segment.style)


class SpyApp(App[None]):
    """Shows a started watch; pictures and recordings are saved to ``folder``."""

    CSS_PATH = "spy.tcss"
    ENABLE_COMMAND_PALETTE = False
    TITLE = "graphnav spy"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "freeze", "freeze", tooltip="freeze the view, or go on"),
        Binding("space", "play", "play", tooltip="play the log, or pause"),
        Binding("comma", "step(-1)", "step", key_display=",.", tooltip="step to the message before, or after"),
        Binding("full_stop", "step(1)", "step forward", show=False, key_display="."),
        Binding("less_than_sign", "skip(-1.0)", "1 s back", show=False, key_display="<"),
        Binding("greater_than_sign", "skip(1.0)", "1 s forward", show=False, key_display=">"),
        Binding("r", "record", "record", tooltip="record all channels into a log, or end it"),
        Binding("w", "save", "save", tooltip="save the screen, or the picture, as PNG"),
        Binding("question_mark", "keys", "keys", key_display="?"),
        Binding("q", "quit", "quit"),
        Binding("ctrl+c", "quit", "quit", show=False, priority=True),
    ]

    def __init__(
        self,
        watch: LiveWatch | LogWatch,
        catalog: Catalog,
        folder: Path,
        new_painter: Callable[[], Painter] = BlockPainter,
    ) -> None:
        super().__init__(driver_class=TerminalDriver, ansi_color=True)
        self._watch = watch
        self._session = Session(watch, catalog, new_painter)
        self._folder = folder
        self._escape = EscapeFilter()

    def get_line_filters(self) -> Sequence[LineFilter]:
        """Return the filters of every line of cells."""
        return [*super().get_line_filters(), self._escape]

    def on_mount(self) -> None:
        """Show the channels."""
        self.push_screen(ChannelsScreen(self._session))
        self.set_interval(_TICK_S, self._play_on)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Return whether a key is active: freezing is for live feeds, stepping for logs."""
        del parameters
        return action not in (_LOG_ONLY if self._watch.is_live else _LIVE_ONLY)

    async def action_quit(self) -> None:
        """Leave."""
        self.leave()

    def leave(self, return_code: int = 0) -> None:
        """Remove raw pictures, which would outlive the screen, and exit."""
        self._session.is_frozen = True
        for screen in self.screen_stack[-1:]:
            for view in screen.query(PictureView):
                view.take_away()
        self.exit(return_code=return_code)

    def action_keys(self) -> None:
        """Show the keys of the screen."""
        if isinstance(self.screen, ChannelScreen | ChannelsScreen):
            self.push_screen(KeysScreen(self.screen))

    def action_freeze(self) -> None:
        """Freeze or unfreeze the view."""
        self._session.is_frozen = not self._session.is_frozen
        self._show()

    def action_play(self) -> None:
        """Play the log in real time, from the beginning if it is at the end; or pause."""
        if isinstance(self._watch, LogWatch):
            self._watch.toggle()
            self._show()

    def action_step(self, count: int) -> None:
        """Step by messages of the open channel, else by timestamps."""
        if isinstance(self._watch, LogWatch):
            screen = self.screen
            self._watch.step(screen.channel_name if isinstance(screen, ChannelScreen) else None, count)
            self._show()

    def action_skip(self, seconds: float) -> None:
        """Step by seconds."""
        if isinstance(self._watch, LogWatch):
            self._watch.skip(seconds)
            self._show()

    def action_record(self) -> None:
        """Start or stop recording all channels."""
        if not isinstance(self._watch, LiveWatch):
            return
        if self._watch.recording is not None:
            self.notify(self._watch.stop_recording(), title="recorded", markup=False)
        else:
            path = self._folder / f"spy-{_time()}.lcmlog"
            try:
                self._watch.record(path)
            except OSError as error:
                self.notify(f"{path}: {error.strerror}", title="cannot record", severity="error", markup=False)
        self._show()

    def action_save(self) -> None:
        """Save the screen, and the picture in its original size, as PNG."""
        screen = self.screen
        name = screen.channel_name if isinstance(screen, ChannelScreen) else "channels"
        path = self._folder / f"spy-{re.sub(r'[^A-Za-z0-9._-]', '_', name)}-{_time()}.png"
        try:
            screen_image(screen).save(path)
        except OSError as error:
            self.notify(f"{path}: {error.strerror or error}", title="cannot save", severity="error", markup=False)
        else:
            self.notify(str(path), title="saved", markup=False)

    def _play_on(self) -> None:
        if isinstance(self._watch, LogWatch) and self._watch.is_playing:
            self._watch.advance()

    def _show(self) -> None:
        """Update the screen immediately."""
        screen = self.screen
        if isinstance(screen, ChannelScreen):
            screen.show(at_once=True)
        elif isinstance(screen, ChannelsScreen):
            screen.show()


def _time() -> str:
    return time.strftime("%Y%m%d-%H%M%S")


def run_app(app: SpyApp) -> int:
    """Run the app; return the exit status: 0, or 128 + N after signal N.

    After SIGTERM and SIGHUP the terminal is restored. A second signal ends the program immediately, even where
    it is blocked by a terminal that takes no more output.
    """
    with plain_ctrl_c():
        asyncio.run(_run(app))
    return app.return_code or 0


async def _run(app: SpyApp) -> None:
    loop = asyncio.get_running_loop()

    def leave(number: int, _frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_DFL)
        loop.call_soon_threadsafe(app.leave, 128 + number)

    before = {number: signal.signal(number, leave) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        await app.run_async()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
