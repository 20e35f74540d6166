"""A table, and how Markdown, HTML, csv and pandas show it; `terminal.py` is for the terminal."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import pandas as pd
    from markupsafe import Markup

Tone = Literal["", "good", "bad", "warning", "clear", "quiet", "strong"]
"""How a cell stands out. "clear": a difference that is clear, of which neither side is better."""

GROUPS_PER_TABLE = 3
"""In Markdown: more would need scrolling, and go into further tables."""
_BOLD: frozenset[Tone] = frozenset({"good", "bad", "clear"})
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
    """Content of a cell that stands out, or is more than a value."""

    text: str = ""
    tone: Tone = ""
    marks: tuple[str, ...] = ()
    """Shown behind the text, in parentheses."""
    is_markdown: bool = False
    """Markdown shows the text as it is, with nothing escaped: its own markup, or a number as ``p < 0.0001``."""


@dataclass(frozen=True)
class Table:
    """Columns and rows; the first column names the row."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[object]]
    """A `Cell`, or a plain value in each column; None where there is none."""
    title: str = ""
    n_fixed: int = 1
    """How many columns each part repeats where the terminal is too narrow for all."""
    n_sums: int = 0
    """How many rows at the end add up those above, and stand below a line."""

    @property
    def header(self) -> list[str]:
        """The names of the columns."""
        return [column.name for column in self.columns]

    def cells(self) -> Iterator[list[Cell]]:
        """Yield the rows for a reader."""
        for row in self.rows:
            yield [value if isinstance(value, Cell) else Cell("" if value is None else str(value)) for value in row]

    def values(self) -> Iterator[list[object]]:
        """Yield the rows for a program: numbers are numbers, and None is None."""
        for row in self.rows:
            yield [value.text if isinstance(value, Cell) else value for value in row]

    def group_sizes(self) -> dict[str, int]:
        """Return the number of columns of each group behind the fixed ones."""
        sizes: dict[str, int] = {}
        for column in self.columns[self.n_fixed :]:
            sizes[column.group] = sizes.get(column.group, 0) + 1
        return sizes

    @staticmethod
    def plain(
        header: Iterable[str],
        rows: Iterable[Sequence[object]],
        *,
        right: Collection[str] = (),
        title: str = "",
        n_fixed: int = 1,
        n_sums: int = 0,
    ) -> Table:
        """Return a table in which each column stands for itself; those that ``right`` names hold aligned numbers."""
        columns = [
            Column(name, f"{place}" if place else "", "right" if name in right else "left")
            for place, name in enumerate(header)
        ]
        return Table(columns, list(rows), title, n_fixed, n_sums)

    def csv_text(self) -> str:
        """Return comma-separated values; numbers so that reading them gives the same number back."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.header)
        writer.writerows(self.values())
        return text.getvalue()

    def data_frame(self, user: str) -> pd.DataFrame:
        """Return a DataFrame; raises UserError, which names the ``user``, without pandas."""
        from graphnav.core.machine.extras import import_pandas

        names = self.header
        rows = [
            {name: value for name, value in zip(names, row, strict=True) if value is not None} for row in self.values()
        ]
        return import_pandas(user).DataFrame(rows, columns=names)

    def markdown_parts(self, groups_per_table: int = GROUPS_PER_TABLE) -> Iterator[str]:
        """Yield Markdown, several tables of a few groups each; only the first has the columns without a group."""
        names = list(dict.fromkeys(column.group for column in self.columns if column.group))
        for first in range(0, max(len(names), 1), groups_per_table):
            some = {*names[first : first + groups_per_table], *([""] if first == 0 else [])}
            shown = [0, *(place for place, column in enumerate(self.columns) if place and column.group in some)]
            lines = [
                [escaped(self.columns[place].name) for place in shown],
                ["---"] * len(shown),
                *([_marked_up(row[place]) for place in shown] for row in self.cells()),
            ]
            yield "\n".join(map(_markdown_row, lines))

    def markdown(self) -> str:
        """Return one table in Markdown, with all columns."""
        [text] = self.markdown_parts(max(len(self.columns), 1))
        return text

    def html(self, kind: Literal["page", "notebook"]) -> Markup:
        """Return HTML.

        On a "page" a style sheet aligns cells, and a wide table scrolls by itself; in a "notebook", whose own style
        aligns cells to the right, those to the left say so.
        """
        from graphnav.core.html_templates import rendered

        aligns = [column.align for column in self.columns]
        values = {"header": self.header, "rows": list(self.cells()), "aligns": aligns}
        return rendered("graphnav.core.tables", f"{kind}.html", **values)


def escaped(text: str) -> str:
    """Return a string that Markdown shows unchanged, in a table too."""
    return text.translate(_ESCAPED)


def _markdown_row(cells: Iterable[str]) -> str:
    """Return one line of a table in Markdown, of cells that are Markdown."""
    return f"| {' | '.join(cells)} |"


def _marked_up(cell: Cell) -> str:
    shown = cell.text if cell.is_markdown else escaped(cell.text)
    text = " ".join([shown, *(f"({escaped(mark)})" for mark in cell.marks)])
    return f"**{text}**" if cell.tone in _BOLD else text
