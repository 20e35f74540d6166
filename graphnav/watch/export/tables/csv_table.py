"""Write CSV tables with unquoted numbers and quoted strings, so that types survive reading back."""

from __future__ import annotations

import csv
from pathlib import Path

from graphnav.watch.export.tables.scalar_fields import Leaf
from graphnav.watch.export.tables.tables import LOG_UTIME, Table


def open_csv(file: Path, leaves: list[Leaf]) -> Table:
    """Return a table that writes UTF-8 with a header line.

    Floats have the digits needed to restore them exactly; other values are written as ``nan``, ``inf``, ``True``.
    """
    stream = file.open("w", encoding="utf-8", newline="")
    writer = csv.writer(stream, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
    writer.writerow([LOG_UTIME, *(leaf.name for leaf in leaves)])
    return Table(writer.writerows, stream.close)
