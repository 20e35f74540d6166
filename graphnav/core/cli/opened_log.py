"""Open the log that a command reads: with what it leaves out, and with its damage told."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav.core.errors import GraphnavError
from graphnav.core.notices import print_notice

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.core.record import Recording


def opened(
    path: Path,
    catalog: Catalog,
    plugins: Sequence[Path] = (),
    channels: Collection[str] | None = None,
) -> Recording:
    """Open a log with what it leaves out of ``channels``, None for all; say so, and show the progress.

    Raises LogError if it cannot be read.
    """
    from graphnav.core.api.logs.open_completed import open_completed
    from graphnav.core.cli.progress import progress_bar
    from graphnav.core.machine.console import Console

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


@contextmanager
def damage_told(recording: Recording) -> Iterator[None]:
    """Report the damage of a log before the error that ends the command: it may be the cause."""
    try:
        yield
    except GraphnavError:
        if notice := recording.damage_notice():
            print_notice(notice)
        raise
