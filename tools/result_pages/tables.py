"""Tables of a page that are made from the results that ship.

Between ``<!-- table STUDY: EXPRESSION -->`` and ``<!-- end of table -->`` stand a row a variant and, in
each cell what the expression gives with ``graph``, ``variant``, ``condition`` and ``metric`` put in, whichever
it names. The columns are the graphs, or their conditions where the expression names ``condition``, or metrics. Options
follow the expression, behind semicolons:

    digits 2                                  of numbers
    metrics sight.auroc, flow_score.epe_px    the columns, of the only graph
    as AUROC, EPE                             the columns' titles
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from result_pages.expression import evaluate
from result_pages.shipped_results import ShippedResults

_TABLE = re.compile(
    r"(?P<begin><!-- table (?P<study>[\w-]+):(?P<body>.*?)-->\n).*?(?P<end><!-- end of table -->)", re.DOTALL
)
_MISSING = ""


def with_tables(markdown: str, read: Callable[[str], ShippedResults] = ShippedResults.read) -> str:
    """Return a page with its tables made again."""

    def made(found: re.Match[str]) -> str:
        return f"{found['begin']}\n{_Table.parse(found['body']).of(read(found['study']))}\n\n{found['end']}"

    return _TABLE.sub(made, markdown)


@dataclass(frozen=True)
class _Table:
    expression: str
    digits: int
    metrics: tuple[str, ...]
    titles: tuple[str, ...]

    @classmethod
    def parse(cls, body: str) -> _Table:
        expression, *rest = (" ".join(part.split()) for part in body.split(";"))
        options = dict(option.split(" ", 1) for option in rest)
        return cls(expression, int(options.get("digits", 0)), _words(options.get("metrics")), _words(options.get("as")))

    def of(self, results: ShippedResults) -> str:
        columns = dict(self._columns(results))
        titles = self.titles or tuple(columns)
        lines = [["", *titles], ["---"] * (len(columns) + 1)]
        lines += [
            [variant, *(self._cell(results, {"variant": variant, **of}) for of in columns.values())]
            for variant in results.variants
        ]
        return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)

    def _columns(self, results: ShippedResults) -> Iterator[tuple[str, Mapping[str, str]]]:
        """Yield the title of each column and what is put in for the words of the expression."""
        for graph in results.graphs:
            short = graph.rpartition("/")[2]
            if re.search(r"\bcondition\b", self.expression):
                for condition in results.conditions(graph):
                    title = condition if len(results.graphs) == 1 else f"{short}, {condition}"
                    yield title, {"graph": graph, "condition": condition}
            elif self.metrics:
                for metric in self.metrics:
                    yield metric, {"graph": graph, "metric": metric}
            else:
                yield short, {"graph": graph}

    def _cell(self, results: ShippedResults, words: Mapping[str, str]) -> str:
        """Return the value of a case; empty where it was not run or no world has the metric."""
        place = re.compile(rf"\b({'|'.join(words)})\b")
        text = place.sub(lambda found: f'"{words[found[1]]}"', self.expression)
        try:
            value = evaluate(text, results)
        except ValueError:
            return _MISSING
        return f"{value:.{self.digits}f}" if isinstance(value, int | float) else str(value)


def _words(text: str | None) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",")) if text else ()
