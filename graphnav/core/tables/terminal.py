"""Tables in the terminal, which are never parsed as markup: in blocks that fit, folded, or cut."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence

from rich import box
from rich.measure import Measurement
from rich.table import Table as RichTable
from rich.text import Text

from graphnav.core.machine.console import Console
from graphnav.core.tables.table import Cell, Table, Tone

_STYLES: dict[Tone, str] = {"good": "green", "bad": "red", "warning": "yellow", "quiet": "dim", "strong": "bold"}
_MAX_COLS = 1000
_PIPED_COLS = 160
_TIGHT = (0, 1, 0, 0)
_LIST = (0, 2, 0, 2)
"""Padding of a table without headings."""


def fitted(console: Console, table: Table, *, is_framed: bool = True) -> list[RichTable]:
    """Return a table as it is where it fits the terminal, else several, each with its fixed columns.

    A group of columns that is too wide alone is separated, its name before the headings that do not have it; cells of
    a column that is too wide alone are wrapped at spaces; no word is cut. Where output is not a terminal and
    ``COLUMNS`` is not set, a table is as wide as it needs, for programs that search its lines.
    """
    layout = _Blocks(console, table, is_framed=is_framed)
    entire = layout.block(range(table.n_fixed, len(table.columns)))
    entire.width = _width(console, entire)
    is_limited = console.is_terminal or "COLUMNS" in os.environ
    if not is_limited or entire.width <= console.width:
        return [entire]
    blocks: list[list[int]] = [[]]
    for group in layout.groups():
        together = [*blocks[-1], *group]
        if blocks[-1] and layout.is_too_wide(together):
            blocks.append(group)
        else:
            blocks[-1] = together
    return [_no_wider(console, layout.block(block, has_title=block is blocks[0])) for block in blocks]


class _Blocks:
    """Makes blocks of some columns of a table, each with the fixed ones."""

    def __init__(self, console: Console, table: Table, *, is_framed: bool) -> None:
        self._console, self._table = console, table
        self._headings = table.header
        self._rows = [list(map(_styled, row)) for row in table.cells()]
        self._row_styles = [_common_style(row) for row in table.cells()]
        self._box = box.SIMPLE_HEAD if is_framed else None

    def groups(self) -> list[list[int]]:
        """Return the columns behind the fixed ones in groups, each for itself where its group is too wide."""
        sizes = self._table.group_sizes()
        groups, begin = list[list[int]](), self._table.n_fixed
        for name, size in sizes.items():
            group = list(range(begin, begin + size))
            begin += size
            if size == 1 or not self.is_too_wide(group):
                groups.append(group)
                continue
            groups += [[place] for place in group]
            for place in group:
                heading = self._headings[place]
                self._headings[place] = heading if name in heading else f"{name}: {heading}"
        return groups

    def is_too_wide(self, places: Sequence[int]) -> bool:
        """Return whether a block does not fit the terminal."""
        return _width(self._console, self.block(places)) > self._console.width

    def block(self, places: Sequence[int], *, has_title: bool = True) -> RichTable:
        """Return the table with its fixed columns and those at ``places``; without headings, if it has none, a list."""
        table = self._table
        title = Text(table.title, style="bold") if table.title and has_title else None
        has_header = any(self._headings)
        block = RichTable(
            box=self._box if has_header else None,
            pad_edge=False,
            padding=(0, 1) if has_header else _LIST,
            show_header=has_header,
            title=title,
            title_justify="left",
        )
        shown = [*range(table.n_fixed), *places]
        for place in shown:
            block.add_column(Text(self._headings[place]), justify=table.columns[place].align)
        last = len(self._rows) - table.n_sums
        for number, (row, style) in enumerate(zip(self._rows, self._row_styles, strict=True), start=1):
            block.add_row(*(row[place] for place in shown), style=style, end_section=number == last)
        return block


def _styled(cell: Cell) -> Text:
    text = Text(cell.text, style=_STYLES.get(cell.tone, ""))
    if cell.marks:
        text.append("".join(f" ({mark})" for mark in cell.marks), style="dim not bold")
    return text


def _common_style(cells: Sequence[Cell]) -> str:
    """Return the style of a row whose cells all have the same tone."""
    tones = {cell.tone for cell in cells}
    return _STYLES.get(tones.pop(), "") if len(tones) == 1 else ""


def _no_wider(console: Console, block: RichTable) -> RichTable:
    """Return a block no wider than the terminal or than its longest words."""
    block.width = _width(console, block)
    if block.width > console.width:
        longest = Measurement.get(console, console.options.update(width=_MAX_COLS), block).minimum
        block.width = max(console.width, longest)
    return block


def _width(console: Console, table: RichTable) -> int:
    options = console.options.update(width=_MAX_COLS, no_wrap=True)
    title = table.title.cell_len if isinstance(table.title, Text) else 0
    return max(Measurement.get(console, options, table).maximum, min(title, console.width))


def print_fitted(console: Console, table: Table, *, is_framed: bool = True) -> None:
    """Print a table in parts that fit the terminal; with a line below the heading if ``is_framed``."""
    for block in fitted(console, table, is_framed=is_framed):
        console.print(block, soft_wrap=True)


def folded(table: Table) -> RichTable:
    """Return a table as wide as the terminal, in which long cells are folded, but not the first column."""
    shown = RichTable(box=box.SIMPLE_HEAD, pad_edge=False, padding=_TIGHT)
    for number, heading in enumerate(table.header):
        shown.add_column(heading, overflow="fold", no_wrap=number == 0)
    for row in table.cells():
        shown.add_row(*map(_styled, row))
    return shown


def print_folded(table: Table) -> None:
    """Print a folded table; without a terminal it is as wide as needed, for programs that search its lines."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_COLS)
    console.print(folded(table))
    console.file.flush()


def cut(table: Table, *, shrinking: Collection[str], wrapped: Collection[str], style: str = "") -> RichTable:
    """Return a table for a screen that is drawn again and again, with a line for each row.

    Where it is too wide, columns in ``shrinking`` end in an ellipsis, those of them in ``wrapped`` go on in further
    lines; others, numbers, are never cut. ``style``: of all of it.
    """
    shown = RichTable(
        box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=_TIGHT, style=style, row_styles=[style]
    )
    for heading in table.header:
        shown.add_column(_unbroken(Text(heading)), no_wrap=heading not in shrinking)
    for row in table.cells():
        texts = zip(table.header, map(_styled, row), strict=True)
        shown.add_row(*(text if heading in wrapped else _unbroken(text) for heading, text in texts))
    return shown


def _unbroken(text: Text) -> Text:
    """Cut a string, with an ellipsis, if its column is too narrow."""
    text.no_wrap, text.overflow = True, "ellipsis"
    return text
