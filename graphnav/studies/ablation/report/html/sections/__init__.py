"""The sections of the report."""

from graphnav.studies.ablation.report.html.sections.decomposition import decomposition
from graphnav.studies.ablation.report.html.sections.failure_gallery import gallery
from graphnav.studies.ablation.report.html.sections.first_screen import overview
from graphnav.studies.ablation.report.html.sections.graph_drawings import drawings
from graphnav.studies.ablation.report.html.sections.pair_matrix import pair_matrices
from graphnav.studies.ablation.report.html.sections.path_maps import maps
from graphnav.studies.ablation.report.html.sections.plots import plots
from graphnav.studies.ablation.report.html.sections.reproduction import reproduce
from graphnav.studies.ablation.report.html.sections.result_tables import tables
from graphnav.studies.ablation.report.html.sections.step_times import timing

__all__ = [
    "decomposition",
    "drawings",
    "gallery",
    "maps",
    "overview",
    "pair_matrices",
    "plots",
    "reproduce",
    "tables",
    "timing",
]
