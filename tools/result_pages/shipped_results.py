"""The results of a study that ship, read from its ``results.csv`` alone."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from graphnav.arrays import Doubles
from graphnav.core.errors import UserError

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results"
"""Each study has a folder of its own here."""
FILE = "results.csv"
METRICS = "metrics.csv"
FAILED = "failed"
"""The outcome of a run in which a stage failed: it does not count as a success."""
_BEFORE_AXES, _AFTER_AXES = "role", "seed"
"""The columns that enclose those of the axes."""

Row = Mapping[str, str]


class NotMeasuredError(UserError):
    """A case was not run, or none of its runs has the metric; all that was named is in the results."""


class Cell(NamedTuple):
    """Whose runs are meant; ``at``: the choice of an axis within which variants are compared, empty without one."""

    graph: str
    variant: str
    at: str = ""


@dataclass(frozen=True)
class ShippedResults:
    """The runs of a study."""

    name: str
    rows: tuple[Row, ...]
    metrics: Mapping[str, Row] = field(default_factory=dict)
    """The rows of ``metrics.csv``, by metric."""

    @classmethod
    def read(cls, name: str, folder: Path = RESULTS) -> ShippedResults:
        """Read ``results.csv`` of a study.

        Raises
        ------
        UserError
            No results of that study ship.
        """
        path = folder / name / FILE
        if not path.is_file():
            known = ", ".join(sorted(one.parent.name for one in folder.glob(f"*/{FILE}"))) or "none"
            raise UserError.of(f"no results of a study '{name}' ship", f"studies with results: {known}")
        metrics = _rows(path.with_name(METRICS)) if path.with_name(METRICS).is_file() else ()
        return cls(name, _rows(path), {row["metric"]: row for row in metrics})

    @property
    def graphs(self) -> tuple[str, ...]:
        """The graphs, in the file's order."""
        return tuple(dict.fromkeys(row["graph"] for row in self.rows))

    @property
    def variants(self) -> tuple[str, ...]:
        """The variants, in the file's order."""
        return tuple(dict.fromkeys(row["variant"] for row in self.rows))

    def runs(self, cell: Cell) -> tuple[Row, ...]:
        """Return the runs of a cell, one a world.

        Raises
        ------
        NotMeasuredError
            There is none.
        UserError
            The results do not have what the cell names, or there are several runs of a world: the condition has to be
            named.
        """
        found = tuple(
            row for row in self._by_case.get(cell[:2], ()) if not cell.at or cell.at in self._conditions_of(row)
        )
        if not found:
            raise (NotMeasuredError if self._knows(cell) else UserError).of(
                f"the results of '{self.name}' have no run of {cell}",
                f"graphs: {', '.join(self.graphs)}; variants: {', '.join(self.variants)}",
            )
        if len({row["seed"] for row in found}) < len(found):
            raise UserError.of(
                f"the results of '{self.name}' have several runs a world of {cell}", "name the condition, at=..."
            )
        return found

    def conditions(self, graph: str) -> tuple[str, ...]:
        """Return the choices of the axis within which variants are compared: a variant was run under all of them."""
        rows = [row for row in self.rows if row["graph"] == graph and row["variant"] == self.variants[0]]
        for choices in zip(*map(self._conditions_of, rows), strict=True):
            if len(set(choices)) > 1:
                return tuple(dict.fromkeys(choices))
        return ()

    def cells(self, graph: str, at: str = "") -> tuple[Cell, ...]:
        """Return the cells of a graph, under one condition."""
        found = (row for row in self.rows if row["graph"] == graph and (not at or at in self._conditions_of(row)))
        return tuple(Cell(graph, variant, at) for variant in dict.fromkeys(row["variant"] for row in found))

    def measured(self, cell: Cell) -> tuple[tuple[str, ...], ...]:
        """Return all that the runs of a cell gave, world by world: variants that share their runs have the same."""
        return tuple(tuple(row.values())[list(row).index(_AFTER_AXES) :] for row in self.runs(cell))

    def min_difference(self, metric: str) -> float:
        """Return the smallest difference of a metric that matters."""
        return float(self.metrics[metric]["min_difference"]) if metric in self.metrics else 0.0

    def is_binary(self, metric: str) -> bool:
        """Return whether a metric is 0 or 1 wherever it is known and is meant to be: nothing with a unit is."""
        if metric not in self._binary:
            has_unit = metric in self.metrics and bool(self.metrics[metric]["unit"])
            known = (float(row[metric]) for row in self.rows if row.get(metric))
            self._binary[metric] = not has_unit and all(value in (0.0, 1.0) for value in known)
        return self._binary[metric]

    def values(self, cell: Cell, metric: str) -> Mapping[int, float]:
        """Return a metric by seed, where it is known; a run in which a stage failed is not a success.

        Raises
        ------
        UserError
            There is no such cell or no such metric.
        """
        return {int(row["seed"]): value for row in self.runs(cell) for value in self._value(row, metric)}

    def paired(self, first: Cell, second: Cell, metric: str) -> tuple[Doubles, Doubles]:
        """Return a metric of two cells in the worlds that both have, by seed."""
        these, those = self.values(first, metric), self.values(second, metric)
        seeds = sorted(these.keys() & those.keys())
        return np.array([these[seed] for seed in seeds]), np.array([those[seed] for seed in seeds])

    def _value(self, row: Row, metric: str) -> Iterator[float]:
        if metric not in row:
            raise UserError.of(f"the results of '{self.name}' have no metric '{metric}'", "see the file's first line")
        text = "0.0" if row["outcome"] == FAILED and metric.endswith(".success") else row[metric]
        if text and math.isfinite(float(text)):
            yield float(text)

    def _knows(self, cell: Cell) -> bool:
        """Whether graph, variant and condition of a cell are in the results, if not together."""
        knows_condition = not cell.at or any(cell.at in self._conditions_of(row) for row in self.rows)
        return cell.graph in self.graphs and cell.variant in self.variants and knows_condition

    def _conditions_of(self, row: Row) -> Sequence[str]:
        columns = list(row)
        return [row[axis] for axis in columns[columns.index(_BEFORE_AXES) + 1 : columns.index(_AFTER_AXES)]]

    @cached_property
    def _binary(self) -> dict[str, bool]:
        """Answers of `is_binary` so far."""
        return {}

    @cached_property
    def _by_case(self) -> Mapping[tuple[str, str], list[Row]]:
        found: dict[tuple[str, str], list[Row]] = {}
        for row in self.rows:
            found.setdefault((row["graph"], row["variant"]), []).append(row)
        return found


def _rows(path: Path) -> tuple[Row, ...]:
    with path.open(newline="", encoding="utf-8") as lines:
        return tuple(csv.DictReader(lines))
