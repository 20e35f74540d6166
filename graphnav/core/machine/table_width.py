"""Tables that fit the terminal: in blocks of columns where they are wider, with nothing cut."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from graphnav.core.machine.console import Console

_MAX_COLS = 1000
_NO_GROUPS: Mapping[str, int] = MappingProxyType({})


def fitted_tables(
    console: Console, table: Table, *, fixed: int = 1, groups: Mapping[str, int] = _NO_GROUPS
) -> list[Table]:
    """Return a table as it is where it fits the terminal, else several, each with the first ``fixed`` columns.

    ``groups``: names and numbers of columns that belong together, behind the fixed ones; none: each stands for itself.
    A group that is too wide alone is separated, its name before the headings that do not have it; cells of a column
    that is too wide alone are wrapped at spaces; no word is cut. Where output is not a terminal and ``COLUMNS`` is not
    set, a table is as wide as it needs, for programs that search its lines.
    """
    table.width = _width(console, table)
    is_limited = console.is_terminal or "COLUMNS" in os.environ
    if not is_limited or table.width <= console.width:
        return [table]
    blocks: list[list[int]] = [[]]
    for group in _groups(console, table, fixed, groups):
        together = [*blocks[-1], *group]
        if blocks[-1] and _width(console, _block(table, fixed, together)) > console.width:
            blocks.append(group)
        else:
            blocks[-1] = together
    return [_fitted(console, _block(table, fixed, block), is_first=block is blocks[0]) for block in blocks]


def _groups(console: Console, table: Table, fixed: int, sizes: Mapping[str, int]) -> list[list[int]]:
    """Return the columns behind the fixed ones in groups, each column for itself where its group is too wide."""
    if not sizes:
        return [[place] for place in range(fixed, len(table.columns))]
    groups, begin = [], fixed
    for name, size in sizes.items():
        group = list(range(begin, begin + size))
        if _width(console, _block(table, fixed, group)) <= console.width:
            groups.append(group)
        else:
            groups += [[place] for place in group]
            for column in (table.columns[place] for place in group):
                heading = str(column.header)
                column.header = Text(heading if name in heading else f"{name}: {heading}")
        begin += size
    return groups


def _block(table: Table, fixed: int, places: Sequence[int]) -> Table:
    """Return the table with its fixed columns and those at ``places``."""
    block = Table(
        box=table.box,
        pad_edge=table.pad_edge,
        padding=table.padding,
        show_header=table.show_header,
        title=table.title,
        title_justify=table.title_justify,
    )
    shown = [*range(fixed), *places]
    for column in (table.columns[place] for place in shown):
        block.add_column(column.header, justify=column.justify, no_wrap=column.no_wrap)
    cells = [list(table.columns[place].cells) for place in shown]
    for number, row in enumerate(table.rows):
        block.add_row(*(column[number] for column in cells), end_section=row.end_section)
    return block


def _fitted(console: Console, block: Table, *, is_first: bool) -> Table:
    """Return a block no wider than the terminal or than its longest words, with the title if it is the first."""
    if not is_first:
        block.title = None
    block.width = _width(console, block)
    if block.width > console.width:
        for column in block.columns:
            column.no_wrap = False
        longest = Measurement.get(console, console.options.update(width=_MAX_COLS), block).minimum
        block.width = max(console.width, longest)
    return block


def _width(console: Console, table: Table) -> int:
    options = console.options.update(width=_MAX_COLS, no_wrap=True)
    title = table.title.cell_len if isinstance(table.title, Text) else 0
    return max(Measurement.get(console, options, table).maximum, min(title, console.width))
