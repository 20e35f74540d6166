"""Tables: one model, and how the terminal, Markdown, HTML, csv and pandas show it."""

from graphnav.core.tables.table import (
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
from graphnav.core.tables.terminal import cut, fitted, folded, print_folded, print_table

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
