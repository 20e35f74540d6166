"""The full screen's link to its terminal, which may be closed at any time."""

from __future__ import annotations

import signal
from collections.abc import Callable
from io import TextIOWrapper
from typing import TYPE_CHECKING, TextIO, cast

from textual.drivers.linux_driver import LinuxDriver

if TYPE_CHECKING:
    from textual.app import App


class TerminalDriver(LinuxDriver):
    """Textual's driver, which ends the app when its terminal was closed, as SIGHUP does.

    Textual's own ends the thread that writes at the first error; the next writes then fill its queue and block the
    program for good, so that no signal but SIGKILL ends it.
    """

    def __init__(
        self, app: App[object], *, debug: bool = False, mouse: bool = True, size: tuple[int, int] | None = None
    ) -> None:
        super().__init__(app, debug=debug, mouse=mouse, size=size)

        def leave() -> None:
            self._loop.call_soon_threadsafe(app.exit, None, 128 + signal.SIGHUP)

        if self._file is not None:
            self._file = cast("TextIOWrapper", _ClosableTerminal(self._file, leave))


class _ClosableTerminal:
    """A terminal's text stream: what is written after the terminal was closed is lost; ``on_close`` is told once."""

    def __init__(self, stream: TextIO, on_close: Callable[[], None]) -> None:
        self._stream = stream
        self._on_close = on_close
        self._is_closed = False

    def fileno(self) -> int:
        """Return the number of the terminal's file."""
        return self._stream.fileno()

    def write(self, text: str) -> None:
        """Write text."""
        try:
            self._stream.write(text)
        except OSError:
            self._close()

    def flush(self) -> None:
        """Write what was kept back."""
        try:
            self._stream.flush()
        except OSError:
            self._close()

    def _close(self) -> None:
        if not self._is_closed:
            self._is_closed = True
            self._on_close()
