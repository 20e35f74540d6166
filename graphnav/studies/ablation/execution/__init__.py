"""Make the runs of a plan in parallel and keep them in the folder of the study."""

from graphnav.studies.ablation.execution.execute_jobs import (
    TaskFactory,
    draw_failures,
    execute,
    pending_drawings,
    pending_jobs,
)
from graphnav.studies.ablation.execution.local_processes import local_workers
from graphnav.studies.ablation.execution.run_times import RunTimes, TimeEstimate
from graphnav.studies.ablation.execution.study_folder import LockedFolder, StudyFolder, read_plan
from graphnav.studies.ablation.execution.workers import Workers, cluster_workers

__all__ = [
    "LockedFolder",
    "RunTimes",
    "StudyFolder",
    "TaskFactory",
    "TimeEstimate",
    "Workers",
    "cluster_workers",
    "draw_failures",
    "execute",
    "local_workers",
    "pending_drawings",
    "pending_jobs",
    "read_plan",
]
