"""The report of a study: one HTML file that needs no other."""

from graphnav.studies.ablation.report.html.page import write_report
from graphnav.studies.ablation.report.html.run_pictures import EarlyMaps

__all__ = [
    "EarlyMaps",
    "write_report",
]
