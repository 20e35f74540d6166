"""The state shared by the screens: the watch, decoding and drawing, freezing and playing."""

from __future__ import annotations

import os
from collections.abc import Callable

from rich.text import Text

from graphnav.core.catalog import Catalog
from graphnav.core.pictures import Pictures
from graphnav.watch.spy.live_watch import LiveWatch
from graphnav.watch.spy.log_watch import LogWatch
from graphnav.watch.spy.moment import Moment
from graphnav.watch.spy.screen.painters.painter import Painter


class Session:
    """One use of the full-screen spy.

    ``is_frozen``: the view is frozen, while messages are still received. ``new_painter`` creates the painter of a view.
    """

    def __init__(self, watch: LiveWatch | LogWatch, catalog: Catalog, new_painter: Callable[[], Painter]) -> None:
        self.watch = watch
        self.moment = Moment(watch, catalog)
        self.pictures = Pictures(catalog)
        self.new_painter = new_painter
        self.has_colour = not os.environ.get("NO_COLOR")
        self.moment.with_colour = self.has_colour
        self.is_frozen = False

    def heading(self) -> Text:
        """Return the description of the feed and of the view."""
        text = Text("graphnav spy  ", "bold") + Text(self.watch.heading())
        for is_so, word in (
            (self.is_frozen, "FROZEN"),
            (isinstance(self.watch, LogWatch) and self.watch.is_playing, "PLAYING"),
        ):
            if is_so:
                text.append("  ")
                text.append(f" {word} ", "bold reverse")
        return text
