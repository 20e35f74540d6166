"""Scalars as tables: one file a channel, a row a message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from graphnav.errors import UserError
from graphnav.export.files.atomic_path import placed_file, placed_folder
from graphnav.export.reader import Reader
from graphnav.export.tables.file_names import file_names
from graphnav.export.tables.scalar_fields import Leaf, Scalar, leaves_of

LOG_UTIME = "log_utime"
"""The first column: when the message was logged, microseconds."""

_ROWS = 4096


class Table(NamedTuple):
    """What writes one file: given rows, some at a time, and at the end nothing more."""

    write: Callable[[list[list[Scalar]]], None]
    close: Callable[[], None]


OpenTable = Callable[[Path, list[Leaf]], Table]


def write_tables(
    reader: Reader, target: Path, channel: str | None, suffix: str, open_table: OpenTable, *, force: bool
) -> list[Path]:
    """Write the scalars of ``channel`` into the file ``target``, else those of every channel into a folder.

    Returns the files that were written.

    Raises
    ------
    UserError
        No selected channel has a type that is installed, or nothing can be written there.
    GraphnavError
        The disk refuses.
    """
    if not reader.channels:
        raise UserError.of("; ".join(reader.losses()), "install the package of the types, or name other channels")
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
