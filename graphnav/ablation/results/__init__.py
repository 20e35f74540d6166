"""The results of a study: records, intervals, comparisons."""

from graphnav.ablation.results.compare_pairs import AllPairs, Contrast, Pair, all_pairs, contrasts
from graphnav.ablation.results.compare_studies import pair_studies
from graphnav.ablation.results.compare_variants import compare
from graphnav.ablation.results.comparison import MIN_WORLDS, Comparison, Difference, Estimate, Row
from graphnav.ablation.results.failures import failure_folder, is_failure, worst_failures
from graphnav.ablation.results.hypothesis_tests import (
    ALPHA,
    EXACT_BELOW,
    Significance,
    mcnemar,
    min_worlds,
    p_value,
    sign_flip,
    t_test,
)
from graphnav.ablation.results.intervals import bonett_price, difference_interval, student, wilson
from graphnav.ablation.results.metric_values import Values, metric_columns, shown_metrics, table_metrics, values_of
from graphnav.ablation.results.pair_text import parse_pairs
from graphnav.ablation.results.paired_studies import PairedRow, PairedStudies
from graphnav.ablation.results.records import Record, in_plan_order, read_record, read_records

__all__ = [
    "ALPHA",
    "EXACT_BELOW",
    "MIN_WORLDS",
    "AllPairs",
    "Comparison",
    "Contrast",
    "Difference",
    "Estimate",
    "Pair",
    "PairedRow",
    "PairedStudies",
    "Record",
    "Row",
    "Significance",
    "Values",
    "all_pairs",
    "bonett_price",
    "compare",
    "contrasts",
    "difference_interval",
    "failure_folder",
    "in_plan_order",
    "is_failure",
    "mcnemar",
    "metric_columns",
    "min_worlds",
    "p_value",
    "pair_studies",
    "parse_pairs",
    "read_record",
    "read_records",
    "shown_metrics",
    "sign_flip",
    "student",
    "t_test",
    "table_metrics",
    "values_of",
    "wilson",
    "worst_failures",
]
