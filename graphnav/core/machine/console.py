"""The console of rich that shows text as it is: neither markup, nor emoji codes, nor escape sequences."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import ExitStack, contextmanager
from typing import IO, TYPE_CHECKING, Any, cast

import rich.console
from rich.file_proxy import FileProxy
from rich.segment import Segment

from graphnav.core.errors import printable
from graphnav.core.machine.escaped_streams import unescaped

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import TextIO

    from rich.console import ConsoleOptions, RenderableType
    from rich.live import Live


class Console(rich.console.Console):
    """Prints strings unchanged, except what `printable` escapes; colours come from styles only.

    ``options``: those of rich's console.
    """

    def __init__(self, **options: Any) -> None:
        self._above = ExitStack()
        super().__init__(markup=False, emoji=False, **options)

    @property
    def file(self) -> IO[str]:
        """The stream that gets rich's own escape sequences."""
        return unescaped(super().file)

    @file.setter
    def file(self, file: IO[str]) -> None:
        self._file = file

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield the segments of a renderable, escaped; rich's own control sequences stay."""
        for segment in super().render(renderable, options):
            if segment.control:
                yield segment
            else:
                yield Segment(printable(segment.text), segment.style)

    def set_live(self, live: Live) -> bool:
        """Begin a display; what is printed appears above it."""
        if self.is_terminal:
            self._above.enter_context(_printed_above(self))
        return super().set_live(live)

    def clear_live(self) -> None:
        """End a display."""
        super().clear_live()
        self._above.close()


class _Above(FileProxy):
    """Prints above a display; rich's own proxy would read escape sequences as styles and links."""

    def write(self, text: str) -> int:
        return super().write(printable(text))


@contextmanager
def _printed_above(console: Console) -> Iterator[None]:
    """Print standard output and error above the display of a console."""
    old = sys.stdout, sys.stderr
    new = (stream and cast("TextIO", _Above(console, stream)) for stream in old)
    sys.stdout, sys.stderr = new
    try:
        yield
    finally:
        for stream in filter(None, (sys.stdout, sys.stderr)):
            stream.flush()
        sys.stdout, sys.stderr = old
