"""A study: its file or command line, axes, seeds, metrics."""

from graphnav.studies.ablation.study.command_line import listed, study_of_command
from graphnav.studies.ablation.study.study import Axis, Choice, Decomposition, MetricExpression, Study
from graphnav.studies.ablation.study.study_keys import STUDY
from graphnav.studies.ablation.study.vary import Vary, parse_varies, vary_of
from graphnav.studies.ablation.study.worlds import parse_worlds, seeds_words

__all__ = [
    "STUDY",
    "Axis",
    "Choice",
    "Decomposition",
    "MetricExpression",
    "Study",
    "Vary",
    "listed",
    "parse_varies",
    "parse_worlds",
    "seeds_words",
    "study_of_command",
    "vary_of",
]
