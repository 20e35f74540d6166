# What the rest of graphnav takes of this folder, each imported on first use.

from .table import (
    Cell,
    Column,
    Table,
    Tone,
    csv_text,
    data_frame,
    escaped,
    html_table,
    markdown_table,
    markdown_tables,
    plain_table,
)
from .terminal import cut, fitted, folded, print_folded, print_table

__all__ = [
    "Cell",
    "Column",
    "Table",
    "Tone",
    "csv_text",
    "cut",
    "data_frame",
    "escaped",
    "fitted",
    "folded",
    "html_table",
    "markdown_table",
    "markdown_tables",
    "plain_table",
    "print_folded",
    "print_table",
]
