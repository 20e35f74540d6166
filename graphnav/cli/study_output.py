"""Write and print the results of a study."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from graphnav.ablation.execution import read_plan
from graphnav.ablation.plan import Plan
from graphnav.ablation.report import (
    METRICS,
    RESULTS,
    TABLE,
    TIMING,
    paired_studies_markdown,
    print_comparison,
    print_contrasts,
    print_paired_studies,
)
from graphnav.ablation.results import Pair, contrasts, pair_studies, read_records
from graphnav.api.studies.study_files import StudyFiles
from graphnav.errors import UserError


def print_outputs(plan: Plan, folder: Path, files: StudyFiles, console: Console, pairs: Sequence[Pair] = ()) -> None:
    """Print the table of a study in short, pairs of its variants, and the files that were written."""
    comparison = files.comparison
    print_comparison(console, comparison, plan)
    print_contrasts(console, contrasts(plan, files.records, pairs), plan)
    for metric in plan.metrics if files.records else ():
        if not comparison.has_metric(metric):
            console.print(f"'{metric}' is undefined in all runs", style="yellow", markup=False)
    if missing := plan.n_jobs - sum(row.runs for row in comparison.rows if not row.case.same_as):
        console.print(f"{missing} of {plan.n_jobs} runs are pending")
    console.print(f"{folder}: {RESULTS}, {METRICS}, {TIMING}, {TABLE}, {files.report.name}", markup=False)


def write_pairing(folder_a: Path, folder_b: Path, file: Path | None, console: Console) -> None:
    """Compare the studies of two folders, world by world; print a short table, write the full one to ``file``.

    Raises
    ------
    UserError
        A folder does not contain a study, they have nothing in common, or the file cannot be written.
    """
    plan_a, plan_b = map(read_plan, (folder_a, folder_b))
    pairing = pair_studies(plan_a, read_records(plan_a, folder_a), plan_b, read_records(plan_b, folder_b))
    print_paired_studies(console, pairing)
    if file is not None:
        try:
            file.write_text(paired_studies_markdown(pairing), encoding="utf-8")
        except OSError as error:
            raise UserError.of(f"cannot write {file}: {error.strerror}", "choose another file with -o") from error
        console.print(str(file), markup=False)
