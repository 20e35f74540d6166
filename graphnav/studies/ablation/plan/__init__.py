"""A checked study: every graph with every variant, loaded before anything runs."""

from graphnav.studies.ablation.plan.build_plan import CheckedStudy, check_study
from graphnav.studies.ablation.plan.compatibility import check_compatible
from graphnav.studies.ablation.plan.plan import RUNS, Case, Job, Plan
from graphnav.studies.ablation.plan.provenance import difference_here, with_versions
from graphnav.studies.ablation.plan.same_drive import shows_same_drive
from graphnav.studies.ablation.plan.upstream import driving_stages

__all__ = [
    "RUNS",
    "Case",
    "CheckedStudy",
    "Job",
    "Plan",
    "check_compatible",
    "check_study",
    "difference_here",
    "driving_stages",
    "shows_same_drive",
    "with_versions",
]
