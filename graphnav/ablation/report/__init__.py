"""The tables and the report of a study."""

from graphnav.ablation.report.csv_files import METRICS, RESULTS, TIMING, write_metrics, write_results, write_timing
from graphnav.ablation.report.decomposition_chart import PICTURE, decomposition_picture
from graphnav.ablation.report.decomposition_text import sentences
from graphnav.ablation.report.html import write_report
from graphnav.ablation.report.markdown import TABLE, bullets, code, document, escaped, table, table_markdown
from graphnav.ablation.report.number_format import difference_text
from graphnav.ablation.report.paired_markdown import paired_studies_markdown
from graphnav.ablation.report.terminal import print_comparison, print_contrasts, print_paired_studies
from graphnav.machine.atomic_write import write_atomically

__all__ = [
    "METRICS",
    "PICTURE",
    "RESULTS",
    "TABLE",
    "TIMING",
    "bullets",
    "code",
    "decomposition_picture",
    "difference_text",
    "document",
    "escaped",
    "paired_studies_markdown",
    "print_comparison",
    "print_contrasts",
    "print_paired_studies",
    "sentences",
    "table",
    "table_markdown",
    "write_atomically",
    "write_metrics",
    "write_report",
    "write_results",
    "write_timing",
]
