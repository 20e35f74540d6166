"""Tables of a page that are made from the results that ship.

Between ``<!-- table STUDY: EXPRESSION -->`` and ``<!-- end of table -->`` stand a row a variant and, in
each cell what the expression gives with ``graph``, ``variant``, ``condition`` and ``metric`` put in, whichever
it names. The columns are the graphs, or their conditions where the expression names ``condition``, or metrics. Options
follow the expression, behind semicolons:

    digits 2                                  of numbers
    metrics sight.auroc, flow_score.epe_px    the columns, of the only graph
    as AUROC, EPE                             the columns' titles

A cell is empty where the case was not run, or no run of it has the metric; all else that has no value is an error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from graphnav.core.errors import UserError
from graphnav.core.tables import Table
from result_pages.expression import MissingError, evaluate
from result_pages.shipped_results import ShippedResults

_TABLE = re.compile(
    r"(?P<begin><!-- table (?P<study>[\w-]+):(?P<body>.*?)-->\n).*?(?P<end><!-- end of table -->)", re.DOTALL
)
_MISSING = ""
_OPTIONS = ("digits", "metrics", "as")


def with_tables(markdown: str, read: Callable[[str], ShippedResults] = ShippedResults.read) -> str:
    """Return a page with its tables made again.

    Raises
    ------
    UserError
        A table cannot be read, or names what the results of its study do not have.
    """

    def made(found: re.Match[str]) -> str:
        try:
            lines = _Table.parse(found["body"]).of(read(found["study"]))
        except ValueError as error:
            what = f"the table {found['study']}: {' '.join(found['body'].split())}: {error}"
            raise UserError.of(what, f"options: {', '.join(_OPTIONS)}; see tools/result_pages/tables.py") from None
        return f"{found['begin']}\n{lines}\n\n{found['end']}"

    return _TABLE.sub(made, markdown)


@dataclass(frozen=True)
class _Table:
    expression: str
    digits: int
    metrics: tuple[str, ...]
    titles: tuple[str, ...]

    @classmethod
    def parse(cls, body: str) -> _Table:
        """Read a table's comment; raise ValueError for options that there are not."""
        expression, *rest = (" ".join(part.split()) for part in body.split(";"))
        options = {name: value for name, _, value in (option.partition(" ") for option in rest)}
        for name, value in options.items():
            if name not in _OPTIONS:
                raise ValueError(f"there is no option '{name}'")
            if not value:
                raise ValueError(f"the option '{name}' has no value")
        digits = options.get("digits", "0")
        if not digits.isdecimal():
            raise ValueError(f"digits are '{digits}', not a number")
        return cls(expression, int(digits), _words(options.get("metrics")), _words(options.get("as")))

    def of(self, results: ShippedResults) -> str:
        """Return the table; raise ValueError where its columns or its cells cannot be made."""
        if self.metrics and (len(results.graphs) > 1 or self._names("condition") or not self._names("metric")):
            raise ValueError(
                "'metrics' is for a study of one graph, and an expression with 'metric' and no 'condition'"
            )
        columns = dict(self._columns(results))
        titles = self.titles or tuple(columns)
        if not columns:
            raise ValueError("the study has no conditions")
        if len(titles) != len(columns):
            raise ValueError(f"'as' has {len(titles)} titles for {len(columns)} columns: {', '.join(columns)}")
        rows = [
            [variant, *(self._cell(results, {"variant": variant, **of}) for of in columns.values())]
            for variant in results.variants
        ]
        return Table.plain(("", *titles), rows).markdown()

    def _columns(self, results: ShippedResults) -> Iterator[tuple[str, Mapping[str, str]]]:
        """Yield the title of each column and what is put in for the words of the expression."""
        for graph in results.graphs:
            short = graph.rpartition("/")[2]
            if self._names("condition"):
                for condition in results.conditions(graph):
                    title = condition if len(results.graphs) == 1 else f"{short}, {condition}"
                    yield title, {"graph": graph, "condition": condition}
            elif self.metrics:
                for metric in self.metrics:
                    yield metric, {"graph": graph, "metric": metric}
            else:
                yield short, {"graph": graph}

    def _names(self, word: str) -> bool:
        return re.search(rf"\b{word}\b", self.expression) is not None

    def _cell(self, results: ShippedResults, words: Mapping[str, str]) -> str:
        """Return the value of a case; empty where it was not run or no run of it has the metric."""
        place = re.compile(rf"\b({'|'.join(words)})\b")
        text = place.sub(lambda found: f'"{words[found[1]]}"', self.expression)
        try:
            value = evaluate(text, results)
        except MissingError:
            return _MISSING
        return f"{value:.{self.digits}f}" if isinstance(value, int | float) else str(value)


def _words(text: str | None) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",")) if text else ()
