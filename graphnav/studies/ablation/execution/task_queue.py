"""Pending tasks, in an order in which processes need not paint the same world again and again."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Iterable
from itertools import groupby

from graphnav.studies.ablation.worker import Task

RUNS_IN_A_ROW = 4
"""Runs through one world that a process makes one after another: more would save little, and let a few variants of an
interrupted study be far ahead of the others."""


class TaskQueue:
    """Hands out tasks in their order, several through one world to one process, until few are left."""

    def __init__(self, tasks: Iterable[Task]) -> None:
        worlds = (list(group) for _, group in groupby(tasks, key=_world))
        self._groups = deque(
            deque(world[first : first + RUNS_IN_A_ROW])
            for world in worlds
            for first in range(0, len(world), RUNS_IN_A_ROW)
        )
        self._taken: dict[Hashable, deque[Task]] = {}

    def __len__(self) -> int:
        """Return the number of pending tasks."""
        return sum(map(len, (*self._groups, *self._taken.values())))

    def take(self, taker: Hashable) -> Task | None:
        """Return the next task of a process: of its world, of the next one, or what another has not begun."""
        own = self._taken.get(taker)
        if not own and self._groups:
            own = self._taken[taker] = self._groups.popleft()
        if not own:
            own = max(self._taken.values(), key=len, default=None)
        return own.popleft() if own else None

    def put_back(self, tasks: Iterable[Task]) -> None:
        """Add tasks that were not begun, as the next ones."""
        self._groups.extendleft(deque([task]) for task in tasks)


def _world(task: Task) -> Hashable:
    """Return what the runs through one world have in common."""
    return task.graph_path, task.seed
