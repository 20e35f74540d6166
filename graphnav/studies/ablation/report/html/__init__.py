"""The report of a study: one HTML file that needs no other."""

from graphnav.studies.ablation.report.html.page import write_report

__all__ = [
    "write_report",
]
