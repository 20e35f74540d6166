"""Plots of metrics: over axes, as profiles, and world by world."""

from graphnav.studies.ablation.report.html.sections.plots.metric_plots import plots
from graphnav.studies.ablation.report.html.sections.plots.parameter_sweeps import axis_numbers, deciding_sweeps

__all__ = [
    "axis_numbers",
    "deciding_sweeps",
    "plots",
]
