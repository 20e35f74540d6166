"""The results of a study: records, intervals, comparisons."""

from graphnav.studies.ablation.results.compare_pairs import AllPairs, Contrast, Pair, all_pairs, contrasts
from graphnav.studies.ablation.results.compare_studies import pair_studies
from graphnav.studies.ablation.results.compare_variants import compare
from graphnav.studies.ablation.results.comparison import Comparison, Difference, Estimate, Row, matters
from graphnav.studies.ablation.results.decomposed import Losses, Swap, losses
from graphnav.studies.ablation.results.fail_condition import (
    FailCondition,
    FailedCase,
    check_fail_conditions,
    failed_cases,
    parse_fail_conditions,
)
from graphnav.studies.ablation.results.failures import failed_run_text, failure_folder, is_failure, worst_failures
from graphnav.studies.ablation.results.metric_values import (
    Values,
    metric_columns,
    paired_differences,
    scaled_values,
    shown_metrics,
    table_metrics,
    values_of,
)
from graphnav.studies.ablation.results.pair_text import parse_pairs
from graphnav.studies.ablation.results.paired_studies import PairedRow, PairedStudies
from graphnav.studies.ablation.results.records import Record, in_plan_order, read_record, read_records
from graphnav.studies.ablation.results.sample_size import sample_size_texts
from graphnav.studies.ablation.results.statistics import (
    ALPHA,
    EXACT_BELOW,
    Significance,
    anytime_p,
    bonett_price,
    difference_interval,
    holm,
    min_worlds,
    p_value,
    student,
    wilson,
)

__all__ = [
    "ALPHA",
    "EXACT_BELOW",
    "AllPairs",
    "Comparison",
    "Contrast",
    "Difference",
    "Estimate",
    "FailCondition",
    "FailedCase",
    "Losses",
    "Pair",
    "PairedRow",
    "PairedStudies",
    "Record",
    "Row",
    "Significance",
    "Swap",
    "Values",
    "all_pairs",
    "anytime_p",
    "bonett_price",
    "check_fail_conditions",
    "compare",
    "contrasts",
    "difference_interval",
    "failed_cases",
    "failed_run_text",
    "failure_folder",
    "holm",
    "in_plan_order",
    "is_failure",
    "losses",
    "matters",
    "metric_columns",
    "min_worlds",
    "p_value",
    "pair_studies",
    "paired_differences",
    "parse_fail_conditions",
    "parse_pairs",
    "read_record",
    "read_records",
    "sample_size_texts",
    "scaled_values",
    "shown_metrics",
    "student",
    "table_metrics",
    "values_of",
    "wilson",
    "worst_failures",
]
