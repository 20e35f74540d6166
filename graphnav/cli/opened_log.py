"""Open the log that a command reads: with what it leaves out, and with its damage told."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.errors import GraphnavError
from graphnav.notices import print_notice

if TYPE_CHECKING:
    from graphnav.catalog import Catalog
    from graphnav.record import Recording
    from graphnav.spy import Feed


def opened(
    path: Path,
    catalog: Catalog,
    plugins: Sequence[Path] = (),
    channels: Collection[str] | None = None,
) -> Recording:
    """Open a log with what it leaves out of ``channels``, None for all; say so, and show the progress.

    Raises LogError if it cannot be read.
    """
    from graphnav.cli.progress import progress_bar
    from graphnav.machine.console import Console
    from graphnav.replay import open_completed

    show: list[Callable[[int], None]] = []
    notices: list[str] = []
    with ExitStack() as shown:

        def on_tick(utime: int) -> None:
            if not show:  # not before: the user may be asked whether plugins may run
                title = f"replay {path.parent.name or path.name}"
                show.append(shown.enter_context(progress_bar(Console(stderr=True), title, None)))
            show[0](utime)

        found = open_completed(path, catalog, plugins, channels=channels, tell=notices.append, on_tick=on_tick)
    for notice in notices:  # below the bar, which has ended
        print_notice(notice)
    return found


def complete(feed: Feed, catalog: Catalog, plugins: Sequence[Path], channels: Collection[str] | None = None) -> Feed:
    """Open the log of a feed, if it is one, with what it leaves out of ``channels``, None for all; return the feed."""
    if not feed.is_live:
        feed.recording = opened(feed.path, catalog, plugins, channels)
    return feed


@contextmanager
def damage_told(recording: Recording) -> Iterator[None]:
    """Report the damage of a log before the error that ends the command: it may be the cause."""
    try:
        yield
    except GraphnavError:
        if notice := recording.damage_notice():
            print_notice(notice)
        raise
