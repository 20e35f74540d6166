"""Write scalars as tables, CSV or Parquet: one file per channel, one row per message."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from graphnav import UserError
from graphnav.watch.export.extras import require
from graphnav.watch.export.files import placed_file, placed_folder
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.scalar_fields import Leaf, Scalar, leaves_of

_LOG_UTIME = "log_utime"
"""The first column: the time at which the message was logged, microseconds."""

_ROWS = 4096
_MAX_CHARACTERS = 200
"""Of a file name."""
_TYPES = {
    "int8_t": "int8",
    "int16_t": "int16",
    "int32_t": "int32",
    "int64_t": "int64",
    "byte": "uint8",
    "float": "float32",
    "double": "float64",
    "boolean": "bool_",
    "string": "string",
}
"""Of Parquet columns, by LCM primitive."""


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


def file_names(channels: Iterable[str], suffix: str) -> dict[str, str]:
    """Return a unique file name for each channel: its name with special characters escaped.

    Characters with a meaning in shells are written as ``%2F``; too long names are cut and numbered.
    """
    names: dict[str, str] = {}
    for number, channel in enumerate(channels):
        name = quote(channel, safe="")
        names[channel] = (name if len(name) <= _MAX_CHARACTERS else f"{name[:_MAX_CHARACTERS]}~{number}") + suffix
    return names


def open_csv(file: Path, leaves: list[Leaf]) -> Table:
    """Return a table that writes UTF-8 with a header line, and quotes strings only: types survive reading back.

    Floats have the digits needed to restore them exactly; other values are written as ``nan``, ``inf``, ``True``.
    """
    stream = file.open("w", encoding="utf-8", newline="")
    writer = csv.writer(stream, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
    writer.writerow([_LOG_UTIME, *(leaf.name for leaf in leaves)])
    return Table(writer.writerows, stream.close)


def open_parquet(file: Path, leaves: list[Leaf]) -> Table:
    """Return a table that writes Parquet, compressed by zstd; raises UserError if pyarrow is not installed."""
    pa, pq = require("pyarrow"), require("pyarrow.parquet")
    columns = [(_LOG_UTIME, "int64"), *((leaf.name, _TYPES[leaf.primitive]) for leaf in leaves)]
    schema = pa.schema([pa.field(name, getattr(pa, kind)(), nullable=False) for name, kind in columns])
    writer = pq.ParquetWriter(file, schema, compression="zstd")

    def write(rows: list[list[Scalar]]) -> None:
        if rows:
            arrays = [
                pa.array(values, field.type) for values, field in zip(zip(*rows, strict=True), schema, strict=True)
            ]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))

    return Table(write, writer.close)
