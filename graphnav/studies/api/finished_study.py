"""A finished study: its tables as DataFrames, and the report."""

from __future__ import annotations

import io
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphnav.core.api import KeptFolder
from graphnav.core.html_templates import rendered
from graphnav.core.machine import Console, import_pandas
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report import print_comparison, runs_data
from graphnav.studies.ablation.results import (
    Comparison,
    Difference,
    Record,
    Row,
    contrasts,
    parse_pairs,
    shown_metrics,
)
from graphnav.studies.api.study_files import StudyFiles

if TYPE_CHECKING:
    import pandas as pd


class Study:
    """The results of a study; in a notebook, its table. A temporary folder exists as long as this object."""

    def __init__(self, plan: Plan, files: StudyFiles, folder: KeptFolder) -> None:
        self.plan = plan
        """The plan: variants, seeds, versions, and the command that repeats it."""
        self.comparison: Comparison = files.comparison
        """The comparison without pandas."""
        self.records: tuple[Record, ...] = files.records
        """The runs without pandas."""
        self._files = files
        self._folder = folder

    @property
    def folder(self) -> Path:
        """Every run, ``results.csv``, ``metrics.csv``, ``timing.csv``, ``table.md``, the report."""
        return self._folder.path

    @property
    def report(self) -> Path:
        """The path of ``report.html``, a self-contained page."""
        return self._files.report

    @cached_property
    def runs(self) -> pd.DataFrame:
        """One row per run: graph, variant, role, axes, seed, outcome, cause, failure, frames, sim_s, metrics.

        The content of ``results.csv``; missing metrics are NaN. Raises UserError without pandas.
        """
        return runs_data(self.plan, self.records).data_frame("Study.runs")

    @cached_property
    def table(self) -> pd.DataFrame:
        """The comparison: a row for each graph, metric and variant (the index), the base first.

        ``worlds``: number of worlds with the metric; ``mean`` with its 95 % interval ``low`` to ``high``; the mean
        paired ``difference`` from the base in the same worlds with its interval; ``won`` and ``lost``: number of worlds
        in which it was better and worse; ``p`` of no difference, and ``p_holm``, adjusted for all comparisons of the
        graph, of the metric that decides; ``clear``: whether that one's difference is significant and matters. The base
        has no difference: NaN, 0, 0 and False.

        Raises UserError without pandas.
        """
        pandas = import_pandas("Study.table")
        rows = list(self._comparisons())
        index = pandas.MultiIndex.from_tuples([key for key, _ in rows], names=["graph", "metric", "variant"])
        return pandas.DataFrame([row for _, row in rows], index=index, columns=list(_COLUMNS))

    def contrast(self, first: str, second: str) -> pd.DataFrame:
        """Compare two variants: a row for each graph and metric (the index).

        ``difference`` is of the first from the second, in the same worlds, with its 95 % interval; ``won``, ``tied``,
        ``lost`` count worlds; ``probability_better`` is the chance that the first is better in a world, plus half that
        of a tie; ``p`` and ``clear`` as in `table`, of this pair alone.

        Raises UserError for what is not two variants of the study, and without pandas.
        """
        pandas = import_pandas("Study.contrast")
        pairs = parse_pairs([f"{first},{second}"], self.plan.variants)
        found = [
            ((pair.graph, metric), _contrast_cells(difference))
            for pair in contrasts(self.plan, self.records, pairs)
            for metric, difference in pair.differences.items()
        ]
        index = pandas.MultiIndex.from_tuples([key for key, _ in found], names=["graph", "metric"])
        return pandas.DataFrame([row for _, row in found], index=index, columns=list(_CONTRAST_COLUMNS))

    def _comparisons(self) -> Iterator[tuple[tuple[str, str, str], dict[str, Any]]]:
        for graph in self.plan.graphs:
            for metric in shown_metrics(self.plan, self.comparison):
                for row in self.comparison.of_graph(graph):
                    if metric in row.estimates:
                        yield (graph, metric, row.case.variant), _cells(row, metric)

    def __repr__(self) -> str:
        n_runs = sum(not self.plan.case(record.graph, record.variant).same_as for record in self.records)
        return f"<graphnav.Study {self.plan.name}: {n_runs} runs, {len(self.plan.variants)} variants, {self.report}>"

    def __str__(self) -> str:
        text = io.StringIO()
        console = Console(file=text, highlight=False, soft_wrap=True, force_jupyter=False)
        print_comparison(console, self.comparison, self.plan)
        return text.getvalue().rstrip()

    def _repr_html_(self) -> str:
        return rendered(
            "graphnav.studies.api", "study.html", about=self.plan.about, table=str(self), report=self.report
        )


_COLUMNS = (
    "worlds", "mean", "low", "high", "difference", "difference_low", "difference_high", "won", "lost", "p",
    "p_holm", "clear",
)  # fmt: skip

_CONTRAST_COLUMNS = (
    "worlds", "difference", "difference_low", "difference_high", "won", "tied", "lost", "probability_better",
    "probability_better_low", "probability_better_high", "p", "clear",
)  # fmt: skip


def _contrast_cells(found: Difference) -> list[Any]:
    chance = found.probability_better
    interval = (found.mean, found.low, found.high)
    worlds = (found.won, found.tied, found.lost)
    return [found.n, *interval, *worlds, chance.mean, chance.low, chance.high, found.p, found.is_clear]


def _cells(row: Row, metric: str) -> dict[str, Any]:
    found, other = row.estimates[metric], row.differences.get(metric)
    cells: dict[str, Any] = {"worlds": found.n, "mean": found.mean, "low": found.low, "high": found.high}
    cells |= {"won": 0, "lost": 0, "clear": False}
    if other is not None:
        cells |= {"difference": other.mean, "difference_low": other.low, "difference_high": other.high}
        cells |= {"won": other.won, "lost": other.lost, "p": other.p, "clear": other.is_clear}
        cells |= {"p_holm": other.significance.p_holm} if other.significance else {}
    return cells
