"""Print the summary of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graphnav.core.cli import counted
from graphnav.core.errors import shown_name
from graphnav.core.runner import size_text

if TYPE_CHECKING:
    from graphnav.watch.recorder import Recorder

_MAX_ROWS = 100


def losses(recorder: Recorder) -> Iterator[str]:
    """Yield the losses by cause, if there are any."""
    if lost := recorder.statistics.lost:
        yield f"{counted(lost, 'message')} lost (missing sequence numbers)"
    if recorder.dropped_packets:
        yield f"{counted(recorder.dropped_packets, 'packet')} dropped by the kernel"
    if recorder.dropped:
        yield f"{counted(recorder.dropped, 'message')} not written"
    if recorder.unnamed:
        yield f"{counted(recorder.unnamed, 'message')} on a channel without a name"


def print_recorded(recorder: Recorder, url: str) -> None:
    """Print a table of the channels, the losses and the files."""
    from graphnav.core.tables import plain_table, print_folded

    statistics = recorder.statistics
    if not statistics.n_messages:
        print(f"no message on {url}")
    else:
        rows = []
        for name in sorted(statistics.channels)[:_MAX_ROWS]:
            channel = statistics.channels[name]
            kind = channel.kind.name if channel.kind is not None else f"unknown, {channel.fingerprint.hex()}"
            lost = f"{channel.lost:,}" if channel.lost is not None else ""
            rows.append((shown_name(name), kind, f"{channel.count:,}", size_text(channel.n_bytes), lost))
        print_folded(plain_table(("channel", "type", "messages", "size", "lost"), rows))
        if (n_more := len(statistics.channels) - _MAX_ROWS) > 0:
            print(f"and {counted(n_more, 'more channel')}")
        if statistics.others.count:
            print(f"and {counted(statistics.others.count, 'message')} on further channels")
    said = "; ".join(losses(recorder)) or "nothing lost"
    print(f"{counted(statistics.n_messages, 'message')}, {size_text(statistics.n_bytes)}; {said}")
    files = recorder.files.paths
    names = str(files[0]) if len(files) == 1 else f"{files[0]} to {files[-1].name} ({len(files)} files)"
    print(f"{names}: {size_text(sum(file.stat().st_size for file in files if file.exists()))}")
