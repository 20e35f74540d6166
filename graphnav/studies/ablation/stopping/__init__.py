"""Add worlds to a study until its results are clear."""

from graphnav.studies.ablation.stopping.rounds import ROUND, check_stopping, jobs_of_next_round, pending_runs
from graphnav.studies.ablation.stopping.stopping_report import stopping_texts

__all__ = [
    "ROUND",
    "check_stopping",
    "jobs_of_next_round",
    "pending_runs",
    "stopping_texts",
]
