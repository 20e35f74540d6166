"""A table of results, and how the terminal, Markdown, csv and pandas show it; the report has a template for it."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from rich import box
from rich.table import Table as RichTable
from rich.text import Text

from graphnav.core.api import import_pandas
from graphnav.core.machine import Console, fitted_tables

if TYPE_CHECKING:
    import pandas as pd

Tone = Literal["", "better", "worse", "clear", "quiet", "strong"]
"""How a cell stands out. "clear": a difference that is clear, of which neither side is better."""

GROUPS_PER_TABLE = 3
"""In Markdown: more would need scrolling, and go into further tables."""
_STYLES: dict[Tone, str] = {"better": "green", "worse": "red", "quiet": "dim", "strong": "bold"}
_BOLD: frozenset[Tone] = frozenset({"better", "worse", "clear"})
_ESCAPED = str.maketrans({"|": "\\|", "\n": " ", "<": "&lt;", "*": "\\*"})


@dataclass(frozen=True)
class Column:
    """The heading of a column. Columns of one ``group``, next to each other, are not separated."""

    name: str
    group: str = ""
    """Empty of what tells rows apart, which stands before all groups."""
    align: Literal["left", "right"] = "left"


@dataclass(frozen=True)
class Cell:
    """Content of a cell, in one line."""

    text: str = ""
    tone: Tone = ""
    marks: tuple[str, ...] = ()
    """Shown behind the text, in parentheses."""
    is_number: bool = False
    """Numbers and words of this package: Markdown shows ``p < 0.0001`` as it is, with nothing escaped."""


@dataclass(frozen=True)
class Table:
    """Columns and rows of cells; the first column names the row."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    title: str = ""
    n_fixed: int = 1
    """How many columns each part repeats where the terminal is too narrow for all."""

    @property
    def header(self) -> list[str]:
        """The names of the columns."""
        return [column.name for column in self.columns]

    def group_sizes(self) -> dict[str, int]:
        """Return the number of columns of each group behind the fixed ones."""
        sizes: dict[str, int] = {}
        for column in self.columns[self.n_fixed :]:
            sizes[column.group] = sizes.get(column.group, 0) + 1
        return sizes


def text_table(header: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> Table:
    """Return a table of strings; each column behind the first is a group of its own."""
    first, *others = header
    columns = [Column(first), *(Column(name, f"{place}") for place, name in enumerate(others))]
    return Table(columns, [[Cell(text) for text in row] for row in rows], title)


def print_table(console: Console, table: Table, *, is_framed: bool = True) -> None:
    """Print a table, in parts that fit the terminal; with a line below the heading if ``is_framed``."""
    title = Text(table.title, style="bold") if table.title else None
    shown = RichTable(box=box.SIMPLE_HEAD if is_framed else None, pad_edge=False, title=title, title_justify="left")
    for column in table.columns:
        shown.add_column(Text(column.name), justify=column.align)
    for row in table.rows:
        shown.add_row(*map(_styled, row))
    sizes = table.group_sizes()
    are_single = all(size == 1 for size in sizes.values())
    for block in fitted_tables(console, shown, fixed=table.n_fixed, groups={} if are_single else sizes):
        console.print(block, soft_wrap=True)


def _styled(cell: Cell) -> Text:
    text = Text(cell.text, style=_STYLES.get(cell.tone, ""))
    if cell.marks:
        text.append("".join(f" ({mark})" for mark in cell.marks), style="dim not bold")
    return text


def markdown_tables(table: Table, groups_per_table: int = GROUPS_PER_TABLE) -> Iterator[str]:
    """Yield a table in Markdown, in several of a few groups each; only the first has the columns without a group."""
    names = list(dict.fromkeys(column.group for column in table.columns if column.group))
    for first in range(0, max(len(names), 1), groups_per_table):
        some = {*names[first : first + groups_per_table], *([""] if first == 0 else [])}
        shown = [0, *(place for place, column in enumerate(table.columns) if place and column.group in some)]
        lines = [
            [escaped(table.columns[place].name) for place in shown],
            ["---"] * len(shown),
            *([_marked_up(row[place]) for place in shown] for row in table.rows),
        ]
        yield "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def markdown_table(table: Table) -> str:
    """Return a table in Markdown, with all its columns."""
    [text] = markdown_tables(table, max(len(table.columns), 1))
    return text


def _marked_up(cell: Cell) -> str:
    shown = cell.text if cell.is_number else escaped(cell.text)
    text = " ".join([shown, *(f"({escaped(mark)})" for mark in cell.marks)])
    return f"**{text}**" if cell.tone in _BOLD else text


def escaped(text: str) -> str:
    """Return a string that Markdown shows unchanged, in a table too."""
    return text.translate(_ESCAPED)


@dataclass(frozen=True)
class Data:
    """A table for other programs: columns, and rows of values, None where there is none."""

    columns: Sequence[str]
    rows: Sequence[Sequence[object]]

    def csv(self) -> str:
        """Return it as comma-separated values; numbers so that reading them gives the same number back."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(self.rows)
        return text.getvalue()

    def frame(self, user: str) -> pd.DataFrame:
        """Return it as a DataFrame; raises UserError, which names the ``user``, without pandas."""
        rows = [
            {name: value for name, value in zip(self.columns, row, strict=True) if value is not None}
            for row in self.rows
        ]
        return import_pandas(user).DataFrame(rows, columns=list(self.columns))
