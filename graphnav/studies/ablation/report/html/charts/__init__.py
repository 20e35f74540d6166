"""Charts as SVG."""

from graphnav.studies.ablation.report.html.charts.bars import stacked_bars
from graphnav.studies.ablation.report.html.charts.lines import FULL_WIDTH, HALF_WIDTH, Point, Series, line_chart
from graphnav.studies.ablation.report.html.charts.parallel import Strand, parallel_chart
from graphnav.studies.ablation.report.html.charts.profiles import Steps, profile_chart
from graphnav.studies.ablation.report.html.charts.whiskers import PANELS, Mark, Panel, whisker_chart

__all__ = [
    "FULL_WIDTH",
    "HALF_WIDTH",
    "PANELS",
    "Mark",
    "Panel",
    "Point",
    "Series",
    "Steps",
    "Strand",
    "line_chart",
    "parallel_chart",
    "profile_chart",
    "stacked_bars",
    "whisker_chart",
]
