"""Write and print the results of a study."""

from __future__ import annotations

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
    print_paired_studies,
)
from graphnav.ablation.results import pair_studies, read_records
from graphnav.api.studies.study_files import write_study_files
from graphnav.catalog import Catalog
from graphnav.errors import UserError


def write_outputs(plan: Plan, folder: Path, catalog: Catalog, console: Console) -> None:
    """Make tables and report from the existing runs, and print the table in short.

    Raises
    ------
    UserError
        A run's summary is not complete.
    GraphnavError
        The disk refuses; what it refuses stays as it was.
    """
    files = write_study_files(plan, folder, catalog)
    comparison = files.comparison
    print_comparison(console, comparison, plan)
    for metric in plan.metrics if files.records else ():
        if not comparison.has_metric(metric):
            console.print(f"'{metric}' is undefined in all runs", style="yellow", markup=False)
    if missing := plan.n_jobs - sum(row.runs for row in comparison.rows if not row.case.same_as):
        console.print(f"{missing} of {plan.n_jobs} runs are pending")
    console.print(f"{folder}: {RESULTS}, {METRICS}, {TIMING}, {TABLE}, {files.report.name}", markup=False)


def write_pairing(folder_a: Path, folder_b: Path, file: Path | None, console: Console) -> None:
    """Compare the studies of two folders, world by world; print that in short and write all of it to ``file``.

    Raises
    ------
    UserError
        A folder holds no study, they have nothing in common, or the file cannot be written.
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
