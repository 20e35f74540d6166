"""The tables and the report of a study."""

from graphnav.studies.ablation.report.csv_files import METRICS, RESULTS, TIMING, runs_data, write_csv_files
from graphnav.studies.ablation.report.decomposition import PICTURE, decomposition_picture, sentences
from graphnav.studies.ablation.report.html import EarlyMaps, write_report
from graphnav.studies.ablation.report.markdown import (
    TABLE,
    bullets,
    code,
    document,
    paired_studies_markdown,
    table_markdown,
)
from graphnav.studies.ablation.report.number_format import difference_text
from graphnav.studies.ablation.report.terminal import print_comparison, print_contrasts, print_paired_studies

__all__ = [
    "METRICS",
    "PICTURE",
    "RESULTS",
    "TABLE",
    "TIMING",
    "EarlyMaps",
    "bullets",
    "code",
    "decomposition_picture",
    "difference_text",
    "document",
    "paired_studies_markdown",
    "print_comparison",
    "print_contrasts",
    "print_paired_studies",
    "runs_data",
    "sentences",
    "table_markdown",
    "write_csv_files",
    "write_report",
]
