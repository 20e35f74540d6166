"""A study: its file or command line, axes, seeds, metrics."""

from graphnav.ablation.study.command_line import study_of_command
from graphnav.ablation.study.metric_expression import MetricExpression
from graphnav.ablation.study.override_targets import Target, settings_of, swaps_of, targets_of
from graphnav.ablation.study.study import Axis, Choice, Study
from graphnav.ablation.study.study_keys import STUDY

__all__ = [
    "STUDY",
    "Axis",
    "Choice",
    "MetricExpression",
    "Study",
    "Target",
    "settings_of",
    "study_of_command",
    "swaps_of",
    "targets_of",
]
