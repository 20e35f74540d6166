"""The results of a study: records, intervals, comparisons."""

from graphnav.ablation.results.compare_studies import pair_studies
from graphnav.ablation.results.compare_variants import compare
from graphnav.ablation.results.comparison import MIN_WORLDS, Comparison, Difference, Estimate, Row
from graphnav.ablation.results.decomposed import Losses, Swap, losses
from graphnav.ablation.results.fail_condition import (
    FailCondition,
    FailedCase,
    check_fail_conditions,
    failed_cases,
    parse_fail_conditions,
)
from graphnav.ablation.results.failures import failed_run_text, failure_folder, is_failure, worst_failures
from graphnav.ablation.results.intervals import DRAWS, SEED, bootstrap, wilson
from graphnav.ablation.results.metric_values import Values, metric_columns, shown_metrics, table_metrics, values_of
from graphnav.ablation.results.paired_studies import PairedRow, PairedStudies
from graphnav.ablation.results.records import Record, in_plan_order, read_record, read_records
from graphnav.ablation.results.sample_size import sample_size_texts

__all__ = [
    "DRAWS",
    "MIN_WORLDS",
    "SEED",
    "Comparison",
    "Difference",
    "Estimate",
    "FailCondition",
    "FailedCase",
    "Losses",
    "PairedRow",
    "PairedStudies",
    "Record",
    "Row",
    "Swap",
    "Values",
    "bootstrap",
    "check_fail_conditions",
    "compare",
    "failed_cases",
    "failed_run_text",
    "failure_folder",
    "in_plan_order",
    "is_failure",
    "losses",
    "metric_columns",
    "pair_studies",
    "parse_fail_conditions",
    "read_record",
    "read_records",
    "sample_size_texts",
    "shown_metrics",
    "table_metrics",
    "values_of",
    "wilson",
    "worst_failures",
]
