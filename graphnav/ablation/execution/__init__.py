"""Make the runs of a plan in parallel and keep them in the folder of the study."""

from graphnav.ablation.execution.execute_jobs import execute, pending_jobs
from graphnav.ablation.execution.failure_pictures import draw_failures, pending_drawings
from graphnav.ablation.execution.local_processes import local_workers
from graphnav.ablation.execution.locked_folder import LockedFolder
from graphnav.ablation.execution.study_folder import StudyFolder, read_plan
from graphnav.ablation.execution.task_factory import TaskFactory
from graphnav.ablation.execution.time_estimate import TimeEstimate, estimate_time
from graphnav.ablation.execution.workers import Workers, cluster_workers

__all__ = [
    "LockedFolder",
    "StudyFolder",
    "TaskFactory",
    "TimeEstimate",
    "Workers",
    "cluster_workers",
    "draw_failures",
    "estimate_time",
    "execute",
    "local_workers",
    "pending_drawings",
    "pending_jobs",
    "read_plan",
]
