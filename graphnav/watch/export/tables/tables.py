"""Write scalars as tables: one file per channel, one row per message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from graphnav import UserError
from graphnav.watch.export.files.atomic_path import placed_file, placed_folder
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.tables.file_names import file_names
from graphnav.watch.export.tables.scalar_fields import Leaf, Scalar, leaves_of

LOG_UTIME = "log_utime"
"""The first column: the time at which the message was logged, microseconds."""

_ROWS = 4096


class Table(NamedTuple):
    """The writer of one file: takes batches of rows, then is closed."""

    write: Callable[[list[list[Scalar]]], None]
    close: Callable[[], None]


OpenTable = Callable[[Path, list[Leaf]], Table]


def write_tables(
    reader: Reader, target: Path, channel: str | None, suffix: str, open_table: OpenTable, *, force: bool
) -> list[Path]:
    """Write the scalars of ``channel`` to the file ``target``, or of all channels to a folder.

    Returns the files that were written.

    Raises
    ------
    UserError
        No selected channel has an installed type, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    if not reader.channels:
        raise UserError.of("; ".join(reader.losses()), "install the package of the types, or select other channels")
    source = reader.recording.path
    if channel is not None:
        with placed_file(target, suffix, source=source, force=force) as file:
            _write(reader, channel, file, open_table)
        return [target]
    names = file_names(reader.channels, suffix)
    with placed_folder(target, source=source, force=force) as folder:
        for name, file_name in names.items():
            _write(reader, name, folder / file_name, open_table)
    return [target / file_name for file_name in names.values()]


def _write(reader: Reader, channel: str, file: Path, open_table: OpenTable) -> None:
    lcm_class = reader.recording.channels[channel]
    assert lcm_class is not None
    leaves = leaves_of(lcm_class)
    table = open_table(file, leaves)
    try:
        rows: list[list[Scalar]] = []
        for sample in reader.of(channel):
            rows.append([sample.utime, *(leaf.of(sample.fields) for leaf in leaves)])
            if len(rows) == _ROWS:
                table.write(rows)
                rows = []
        table.write(rows)
    finally:
        table.close()
