"""Write the tables and the report of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from graphnav import Graph
from graphnav.core.catalog import Catalog
from graphnav.core.machine import write_atomically
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report import (
    PICTURE,
    TABLE,
    decomposition_picture,
    table_markdown,
    write_csv_files,
    write_report,
)
from graphnav.studies.ablation.results import (
    Comparison,
    Losses,
    Record,
    compare,
    losses,
    read_records,
    sample_size_texts,
)
from graphnav.studies.ablation.stopping import pending_runs, stopping_texts


@dataclass(frozen=True)
class StudyFiles:
    """The files of a study and the data in them."""

    records: tuple[Record, ...]
    comparison: Comparison
    notes: tuple[str, ...]
    """Sentences on the number of worlds: when a study was stopped, and how many an unclear difference needs."""
    report: Path
    losses: tuple[Losses, ...] = ()
    """Of a decomposed study."""


def write_study_files(
    plan: Plan,
    folder: Path,
    catalog: Catalog,
    graphs: Mapping[str, Graph] = MappingProxyType({}),
    drawn: frozenset[Path] = frozenset(),
) -> StudyFiles:
    """Make tables and report from the existing runs of a study.

    ``graphs``: those loaded already, by `Case.folder`; ``drawn``: maps that are drawn already (`EarlyMaps`).

    Raises
    ------
    UserError
        A run's summary is incomplete.
    GraphnavError
        A file cannot be written; its old version is kept.
    """
    records = read_records(plan, folder)
    comparison = compare(plan, records, pending_runs(plan, records))
    write_csv_files(plan, records, folder)
    found = losses(plan, records)
    notes = (*stopping_texts(plan, records), *sample_size_texts(plan, comparison, records))
    write_atomically(folder / TABLE, table_markdown(plan, comparison, found, notes))
    if told := [of for of in found if not of.is_cut_off]:
        write_atomically(folder / PICTURE, decomposition_picture(told))
    else:
        (folder / PICTURE).unlink(missing_ok=True)
    report = write_report(plan, comparison, records, folder, catalog, graphs, notes, drawn)
    return StudyFiles(records, comparison, notes, report, found)
