"""One run of a study, made in a process of its own."""

from graphnav.studies.ablation.worker.perform_task import ENDING, IDLE_S, NOT_DRAWN, STALL_S, Result, Task

__all__ = [
    "ENDING",
    "IDLE_S",
    "NOT_DRAWN",
    "STALL_S",
    "Result",
    "Task",
]
