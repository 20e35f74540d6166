"""Tune the parameters of rivals with the same budget: the same number of trials, in the same worlds."""

from graphnav.studies.tuning.rivals import Rival
from graphnav.studies.tuning.search_range import parse_searches
from graphnav.studies.tuning.trial import Trial
from graphnav.studies.tuning.tuned_files import STUDY, TABLE, TRIALS, TUNING, begin_tuning, write_tuning
from graphnav.studies.tuning.tuned_table import OPTIMISTIC, conclusion, params_text, trouble_texts, tuned_table
from graphnav.studies.tuning.tuning import Tuning, TuningRequest, check_tuning, named_after
from graphnav.studies.tuning.tuning_run import TuningRun, run_tuning

__all__ = [
    "OPTIMISTIC",
    "STUDY",
    "TABLE",
    "TRIALS",
    "TUNING",
    "Rival",
    "Trial",
    "Tuning",
    "TuningRequest",
    "TuningRun",
    "begin_tuning",
    "check_tuning",
    "conclusion",
    "named_after",
    "params_text",
    "parse_searches",
    "run_tuning",
    "trouble_texts",
    "tuned_table",
    "write_tuning",
]
