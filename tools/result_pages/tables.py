"""Tables of a page that are made from the results that ship.

Between ``<!-- table STUDY: EXPRESSION; by variant -->`` and ``<!-- end of table -->`` stands what is generated: a row a
variant, a column a graph, and in each cell what the expression gives with ``graph`` and ``variant`` put in.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from result_pages.expression import evaluate
from result_pages.shipped_results import ShippedResults

_TABLE = re.compile(
    r"(?P<begin><!-- table (?P<study>[\w-]+): (?P<expression>[^;]+?)(?:; digits (?P<digits>\d))? -->\n)"
    r".*?(?P<end><!-- end of table -->)",
    re.DOTALL,
)
_MISSING = ""


def with_tables(markdown: str, read: Callable[[str], ShippedResults] = ShippedResults.read) -> str:
    """Return a page with its tables made again."""

    def made(found: re.Match[str]) -> str:
        table = _table(read(found["study"]), found["expression"], int(found["digits"] or 0))
        return f"{found['begin']}\n{table}\n\n{found['end']}"

    return _TABLE.sub(made, markdown)


def _table(results: ShippedResults, expression: str, digits: int) -> str:
    lines = [
        ["", *(graph.rpartition("/")[2] for graph in results.graphs)],
        ["---"] * (len(results.graphs) + 1),
        *(
            [variant, *(_cell(results, expression, graph, variant, digits) for graph in results.graphs)]
            for variant in results.variants
        ),
    ]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _cell(results: ShippedResults, expression: str, graph: str, variant: str, digits: int) -> str:
    """Return the value of a case; empty where it was not run or no world has the metric."""
    text = re.sub(r"\bgraph\b", f'"{graph}"', re.sub(r"\bvariant\b", f'"{variant}"', expression))
    try:
        value = evaluate(text, results)
    except ValueError:
        return _MISSING
    return f"{value:.{digits}f}" if isinstance(value, int | float) else str(value)
