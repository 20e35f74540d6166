"""Tables in the terminal whose cells are plain text."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from graphnav.core.machine.console import Console


class TextTable(Table):
    """A table without frames; long cells are folded, and cells are not parsed as markup."""

    def __init__(self, *headings: str) -> None:
        super().__init__(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
        for number, heading in enumerate(headings):
            self.add_column(heading, overflow="fold", no_wrap=number == 0)

    def add_text(self, *cells: str) -> None:
        """Append a row."""
        self.add_row(*map(Text, cells))


_PIPED_COLS = 160


def print_table(table: TextTable) -> None:
    """Print a table; without a terminal it is as wide as needed, for programs that search its lines."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=_PIPED_COLS)
    console.print(table)
    console.file.flush()
