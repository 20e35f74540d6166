"""Statements of a page, and whether the results that ship bear them out.

A paragraph or a list item that gives a number or compares is followed by a comment that GitHub and the book hide:

    The homography arrives in 48 of 50 worlds, ICA in 3.
    <!-- check suite: arrive("shake", "homography") == 48; worlds("shake", "ica") == 50; arrive("shake", "ica") == 3 -->

Every expression has to be true, and every number of the text has to stand in the comment: in an expression, or behind
``given`` where it is not a result (``given 0.5`` for a parameter). How many digits ``round`` and ``interval`` keep does
not count.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import yaml  # noqa: TID251  # a list of this repository

from graphnav.core.errors import UserError
from result_pages.expression import evaluate, left_side, without_digits
from result_pages.shipped_results import ShippedResults

_CHECK = re.compile(r"<!--\s*check\s+(?P<study>[\w-]+):(?P<body>.*?)-->", re.DOTALL)
_GIVEN = re.compile(r"^given\b")
_NOT_PROSE = re.compile(r"`[^`]*`|\]\([^)]*\)|<!--.*?-->", re.DOTALL)
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:[.,]\d+)*")
_COMPARES = re.compile(
    r"\b(more|less|fewer|better|worse|best|worst|leads?|than|all|none|never|always|every|only|no|neither|both|equals?|"
    r"fails?|arrives?|higher|lower|beats?|ahead|behind|as well as|as many|separates?|half|most)\b",
    re.IGNORECASE,
)
_UNCHECKED = ("#", "|", "![", "```", "<!--")
"""How blocks begin that state nothing, or that are generated: headings, tables, pictures, code, comments."""


@dataclass(frozen=True)
class Claim:
    """A paragraph or a list item with its check."""

    line: int
    text: str
    """Without the comment."""
    study: str
    expressions: tuple[str, ...]
    given: str

    def problems(self, results: ShippedResults) -> Iterator[str]:
        """Yield what the results do not bear out, and the numbers that nothing checks."""
        for expression in self.expressions:
            try:
                holds = evaluate(expression, results)
            except ValueError as error:
                yield f"line {self.line}: {expression}: {error}"
            else:
                if holds is not True:
                    yield f"line {self.line}: not true: {expression} (left side: {_left(expression, results)})"
        stated = [*map(without_digits, self.expressions), self.given]
        checked = set(_NUMBER.findall(" ".join(stated).replace('"', " ")))
        for number in dict.fromkeys(_NUMBER.findall(_NOT_PROSE.sub(" ", self.text))):
            if number.lstrip("+") not in checked:
                yield f"line {self.line}: the number {number} is not in the check"


def claims(markdown: str) -> Iterator[Claim]:
    """Yield the checked statements of a page."""
    for line, block in _blocks(markdown):
        for found in _CHECK.finditer(block):
            parts = [" ".join(part.split()) for part in found["body"].split(";")]
            yield Claim(
                line,
                _CHECK.sub("", block).strip(),
                found["study"],
                tuple(part for part in parts if part and not _GIVEN.match(part)),
                " ".join(part for part in parts if _GIVEN.match(part)),
            )


def listed_claims(listed: str, markdown: str) -> Iterator[Claim]:
    """Yield the statements that a YAML list checks for a page without comments, one for each study that bears one out.

    Raises `UserError` for a statement that the page does not make, and for a row of a table with numbers that the list
    leaves out.
    """
    said = " ".join(markdown.split())
    entries = yaml.safe_load(listed)
    for entry in entries:
        text = " ".join(entry["says"].split())
        if text not in said:
            raise UserError.of(f"the page does not say: {text}")
        numbers = " ".join(without_digits(one) for some in entry["holds"].values() for one in some)
        given = f"{entry.get('given', '')} {numbers}"
        for study, expressions in entry["holds"].items():
            yield Claim(1 + markdown[: markdown.find(text[:20])].count("\n"), text, study, tuple(expressions), given)
    rows = {" ".join(entry["says"].split()) for entry in entries}
    for row in re.findall(r"^\|.*\|$", markdown, re.MULTILINE):
        if _NUMBER.search(_NOT_PROSE.sub(" ", row)) and " ".join(row.split()) not in rows:
            raise UserError.of(f"nothing checks the row: {row}")


def unchecked(markdown: str) -> Iterator[str]:
    """Yield the statements of a page that give a number or compare, and have no check."""
    for line, block in _blocks(markdown):
        prose = _NOT_PROSE.sub(" ", block)
        if (_NUMBER.search(prose) or _COMPARES.search(prose)) and not _CHECK.search(block):
            yield f"line {line}: no check: {' '.join(block.split())[:80]}"


def _left(expression: str, results: ShippedResults) -> object:
    """Return the value of what stands before the first comparison; why it has none."""
    try:
        return evaluate(left_side(expression), results)
    except ValueError as error:
        return error


def _blocks(markdown: str) -> Iterator[tuple[int, str]]:
    """Yield paragraphs and list items with the number of their first line; a comment belongs to what is before it."""
    block: list[str] = []
    first, is_code, is_comment = 1, False, False
    for number, line in enumerate([*markdown.split("\n"), ""], 1):
        if line.startswith("```"):
            is_code = not is_code
        begins_item = bool(re.match(r"\s*(-|\d+\.) ", line)) and not is_comment
        if not is_comment and (not line.strip() or begins_item or is_code):
            if block and not block[0].lstrip().startswith(_UNCHECKED):
                yield first, "\n".join(block)
            block, first = [], number
        if line.strip() and not is_code and not line.startswith("```"):
            block.append(line)
        is_comment = (is_comment or "<!--" in line) and "-->" not in line.rpartition("<!--")[2]
