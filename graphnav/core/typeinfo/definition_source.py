"""The source text of a ``.lcm`` file: strip comments, locate fields."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from graphnav.core.errors import Place, UserError
from graphnav.core.machine.files import read_regular

MAX_BYTES = 16 * 1024**2
"""Of a file of definitions."""
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


@dataclass(frozen=True)
class DefinitionSource:
    """A ``.lcm`` file and its text without comments; line numbers are preserved.

    lcm-gen copies comments into docstrings of the generated Python, where quotes in a comment would end the docstring
    and turn the rest of the comment into code.
    """

    path: Path
    text: str

    @classmethod
    def of(cls, path: Path, text: str) -> Self:
        """Return the source with comments stripped."""
        return cls(path, _COMMENT.sub(_blank, text.replace("\0", " ")))

    def place_of_field(self, typename: str, name: str) -> Place | None:
        """Return where a field is declared, None if not in this file."""
        short = re.escape(typename.rpartition(".")[2])
        found = re.search(rf"(?<!\w)(?:[\w.]+\.)?{short}\s+{re.escape(name)}\b", self.text)
        if found is None:
            return None
        line_start = self.text.rfind("\n", 0, found.start()) + 1
        line = self.text.count("\n", 0, found.start()) + 1
        return Place(str(self.path), line, found.start() - line_start + 1)


def read_definition(path: Path) -> DefinitionSource:
    """Read a ``.lcm`` file.

    Raises
    ------
    UserError
        It cannot be read.
    """
    try:
        text = read_regular(path, MAX_BYTES).decode("utf-8", "replace")
    except OSError as error:
        raise UserError.of(f"cannot read {path}: {error.strerror}", place=Place("--types")) from error
    return DefinitionSource.of(path, text)


def _blank(comment: re.Match[str]) -> str:
    return re.sub(r"[^\n]", " ", comment[0])
