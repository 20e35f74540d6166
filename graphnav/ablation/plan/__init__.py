"""A checked study: every graph with every variant, loaded before anything runs."""

from graphnav.ablation.plan.build_plan import make_plan
from graphnav.ablation.plan.compatibility import check_compatible
from graphnav.ablation.plan.plan import RUNS, Case, Job, Plan
from graphnav.ablation.plan.provenance import difference_here, with_versions

__all__ = [
    "RUNS",
    "Case",
    "Job",
    "Plan",
    "check_compatible",
    "difference_here",
    "make_plan",
    "with_versions",
]
