"""A checked study: every graph with every variant, loaded before anything runs."""

from graphnav.studies.ablation.plan.build_plan import CheckedStudy, check_study
from graphnav.studies.ablation.plan.plan import RUNS, Case, Job, Plan
from graphnav.studies.ablation.plan.plan_file import load_plan, save_plan
from graphnav.studies.ablation.plan.provenance import check_compatible, shows_same_drive, with_versions
from graphnav.studies.ablation.plan.upstream import driving_stages

__all__ = [
    "RUNS",
    "Case",
    "CheckedStudy",
    "Job",
    "Plan",
    "check_compatible",
    "check_study",
    "driving_stages",
    "load_plan",
    "save_plan",
    "shows_same_drive",
    "with_versions",
]
