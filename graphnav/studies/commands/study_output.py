"""Write and print the results of a study."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from graphnav import UserError
from graphnav.core.cli import Exit
from graphnav.core.machine import Console
from graphnav.core.runner import Outcome
from graphnav.studies.ablation.execution import read_plan
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report import (
    METRICS,
    PICTURE,
    RESULTS,
    TABLE,
    TIMING,
    difference_text,
    paired_studies_markdown,
    print_comparison,
    print_contrasts,
    print_paired_studies,
    sentences,
)
from graphnav.studies.ablation.results import (
    FailedCase,
    Pair,
    check_fail_conditions,
    contrasts,
    failed_cases,
    pair_studies,
    parse_fail_conditions,
    read_records,
)
from graphnav.studies.api.study_files import StudyFiles


def print_outputs(plan: Plan, folder: Path, files: StudyFiles, console: Console, pairs: Sequence[Pair] = ()) -> None:
    """Print the table of a study in short, pairs of its variants, and the files that were written."""
    comparison = files.comparison
    print_comparison(console, comparison, plan)
    print_contrasts(console, contrasts(plan, files.records, pairs), plan)
    for metric in plan.metrics if files.records else ():
        if not comparison.has_metric(metric):
            console.print(f"'{metric}' is undefined in all runs", style="yellow", markup=False)
    for note in files.notes:
        console.print(note, style="dim", markup=False)
    if comparison.pending and plan.until_clear:
        console.print(f"{comparison.pending} of the runs of the next round are pending")
    elif comparison.pending:
        console.print(f"{comparison.pending} of {plan.n_jobs} runs are pending")
    for of in files.losses:
        console.print(" ".join(sentences(plan, of)), markup=False)
    pictures = [PICTURE] if any(not of.is_cut_off for of in files.losses) else []
    written = [RESULTS, METRICS, TIMING, TABLE, *pictures, files.report.name]
    console.print(f"{folder}: {', '.join(written)}", markup=False)


def study_status(files: StudyFiles) -> int:
    """Return the exit status of a study: 1, and say so, if there are runs and every one failed."""
    if not files.records or any(record.outcome != Outcome.FAILED for record in files.records):
        return Exit.OK
    print(f"every run failed: {len(files.records)} of {len(files.records)}", file=sys.stderr)
    return Exit.FAILED


def write_pairing(folder_a: Path, folder_b: Path, file: Path | None, fail_if: Sequence[str], console: Console) -> int:
    """Compare the studies of two folders, world by world; print a short table, write the full one to ``file``.

    Returns the exit status: 1 if a case meets a condition of ``fail_if``, or cannot be judged by it.

    Raises
    ------
    UserError
        A condition cannot be read or names an unknown metric, a folder does not contain a study, they have nothing in
        common, or the file cannot be written.
    """
    conditions = parse_fail_conditions(fail_if)
    plan_a, plan_b = map(read_plan, (folder_a, folder_b))
    runs_a, runs_b = read_records(plan_a, folder_a), read_records(plan_b, folder_b)
    pairing = pair_studies(plan_a, runs_a, plan_b, runs_b, [condition.column for condition in conditions])
    check_fail_conditions(conditions, pairing)
    print_paired_studies(console, pairing)
    if file is not None:
        try:
            file.write_text(paired_studies_markdown(pairing), encoding="utf-8")
        except OSError as error:
            raise UserError.of(f"cannot write {file}: {error.strerror}", "choose another file with -o") from error
        console.print(str(file), markup=False)
    failed = list(failed_cases(conditions, pairing))
    for case in failed:
        console.print(_failed_case_text(case), style="red", markup=False)
    return Exit.FAILED if failed else Exit.OK


def _failed_case_text(case: FailedCase) -> str:
    where = f"{case.condition.text}: {case.graph}, {case.variant}"
    if case.is_of_frames:
        return f"{where}: this depends on the frames, and the plans do not show that the drive is the same in both"
    if case.difference is None:
        return f"{where}: no world of both studies has this metric"
    return f"{where}: B - A is {difference_text(case.difference)}"
