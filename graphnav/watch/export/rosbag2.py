"""Export a log as a ROS 2 bag."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from graphnav import UserError
from graphnav.core.errors import shown_name
from graphnav.core.record import BagWriter
from graphnav.watch.export.files import placed_folder
from graphnav.watch.export.reader import Reader


def write_bag(reader: Reader, target: Path, storage: str, *, force: bool) -> tuple[list[str], list[Path]]:
    """Write the messages that have a standard ROS type as a bag in the folder ``target``.

    ``storage``: ``mcap`` or ``sqlite3``. Returns what is left out, a sentence each, and the files.

    Raises
    ------
    UserError
        No selected channel has a ROS type, the extra ``bags`` is not installed, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    kinds = {name: reader.message_type(name) for name in reader.channels}
    taken = {name for name, kind in kinds.items() if BagWriter.takes(kind)}
    if not taken:
        raise UserError.of(
            f"nothing to export from {reader.recording.path}: no selected channel has a standard ROS type",
            "select other channels with --channel, or export to csv or mcap",
        )
    with placed_folder(target, source=reader.recording.path, force=force) as folder:
        made = folder / target.name  # a bag's files bear the name of its folder
        writer = BagWriter(made, storage)
        is_complete = False
        try:
            unwritten = _write(reader, taken, writer)
            is_complete = True
        finally:
            writer.close(is_complete=is_complete)
        names = sorted(file.name for file in made.iterdir())
        for name in names:
            (made / name).rename(folder / name)
        made.rmdir()
    losses = [*_left_out(kinds.keys() - taken, kinds), *unwritten, *reader.losses()]
    return losses, [target / name for name in names]


def _write(reader: Reader, taken: set[str], writer: BagWriter) -> list[str]:
    """Write the messages; return a sentence for each channel of which some cannot be."""
    unwritten: Counter[str] = Counter()
    for event in reader.recording.events():
        if event.channel not in taken or not reader.holds(event):
            continue
        sample = reader.decoded(event)
        if sample is None:
            continue
        message = reader.message(event.channel, sample.fields)
        utime = sample.fields.get("utime", event.utime)
        if message is None or not writer.write(event.channel, event.utime, utime, message):
            unwritten[event.channel] += 1
    return [
        f"channel {name!r}: {count} messages left out: their ROS type cannot hold their numbers or times"
        for name, count in unwritten.items()
    ]


def _left_out(names: set[str], kinds: dict[str, type | None]) -> list[str]:
    """Return a sentence that names the channels without a ROS type."""
    if not names:
        return []
    told = ", ".join(
        f"{shown_name(name)} ({kind.__name__})" if kind is not None else shown_name(name)
        for name, kind in kinds.items()
        if name in names
    )
    count = "1 channel has" if len(names) == 1 else f"{len(names)} channels have"
    return [f"{count} no standard ROS type, left out: {told}"]
