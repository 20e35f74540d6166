"""Tune the parameters of rivals with the same budget: the same number of trials, in the same worlds."""

from graphnav.tuning.request import TuningRequest
from graphnav.tuning.rivals import Rival
from graphnav.tuning.search_range import SearchRange, parse_searches
from graphnav.tuning.trial import Trial
from graphnav.tuning.tuned_files import TABLE, TRIALS, TUNING, begin_tuning, write_tuning
from graphnav.tuning.tuned_study import STUDY
from graphnav.tuning.tuned_table import OPTIMISTIC, conclusion, header, rows, trouble_texts
from graphnav.tuning.tuning import Tuning, check_tuning, named_after
from graphnav.tuning.tuning_run import TuningRun, run_tuning

__all__ = [
    "OPTIMISTIC",
    "STUDY",
    "TABLE",
    "TRIALS",
    "TUNING",
    "Rival",
    "SearchRange",
    "Trial",
    "Tuning",
    "TuningRequest",
    "TuningRun",
    "begin_tuning",
    "check_tuning",
    "conclusion",
    "header",
    "named_after",
    "parse_searches",
    "rows",
    "run_tuning",
    "trouble_texts",
    "write_tuning",
]
