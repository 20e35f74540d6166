"""Write Parquet tables, each column in the field's LCM type."""

from __future__ import annotations

from pathlib import Path

from graphnav.watch.export.extras import require
from graphnav.watch.export.tables.scalar_fields import Leaf, Scalar
from graphnav.watch.export.tables.tables import LOG_UTIME, Table

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


def open_parquet(file: Path, leaves: list[Leaf]) -> Table:
    """Return a table that writes Parquet, compressed by zstd; raises UserError if pyarrow is not installed."""
    pa, pq = require("pyarrow"), require("pyarrow.parquet")
    columns = [(LOG_UTIME, "int64"), *((leaf.name, _TYPES[leaf.primitive]) for leaf in leaves)]
    schema = pa.schema([pa.field(name, getattr(pa, kind)(), nullable=False) for name, kind in columns])
    writer = pq.ParquetWriter(file, schema, compression="zstd")

    def write(rows: list[list[Scalar]]) -> None:
        if rows:
            arrays = [
                pa.array(values, field.type) for values, field in zip(zip(*rows, strict=True), schema, strict=True)
            ]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))

    return Table(write, writer.close)
