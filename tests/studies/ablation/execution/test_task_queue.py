"""Every task is handed out once; runs through one world go to one process."""

from __future__ import annotations

import random
from collections.abc import Iterable

import pytest

from graphnav.studies.ablation.execution.local_processes import RUNS_IN_A_ROW, TaskQueue, in_rows
from graphnav.studies.ablation.worker import Task


def tasks(seeds: Iterable[int], variants: int) -> list[Task]:
    return [
        Task(f"runs/{variant}/{seed}", "stages: {}", "a.yaml", (), seed, (), {})
        for seed in seeds
        for variant in range(variants)
    ]


@pytest.mark.parametrize("takers", [1, 2, 5, 40])
@pytest.mark.parametrize("variants", [1, 3, 11])
def test_every_task_is_handed_out_once(takers: int, variants: int) -> None:
    wanted, rng = tasks(range(7), variants), random.Random(takers)
    queue, taken = TaskQueue(wanted), []
    while task := queue.take(rng.randrange(takers)):
        taken.append(task)
        assert len(queue) == len(wanted) - len(taken)
    assert sorted(task.folder for task in taken) == sorted(task.folder for task in wanted)


def test_one_process_gets_the_order_of_the_study() -> None:
    wanted = tasks(range(3), 9)
    queue = TaskQueue(wanted)
    assert [queue.take("a") for _ in wanted] == wanted


def test_runs_through_one_world_go_to_one_process() -> None:
    queue = TaskQueue(tasks(range(4), 3))
    taken = [(taker, task.seed) for _ in range(6) for taker in "ab" if (task := queue.take(taker))]
    assert set(taken) == {("a", 0), ("b", 1), ("a", 2), ("b", 3)}


def test_of_many_variants_several_processes_share_a_world() -> None:
    queue = TaskQueue(tasks(range(2), 2 * RUNS_IN_A_ROW))
    seeds = [task.seed for _ in range(RUNS_IN_A_ROW) for taker in "ab" if (task := queue.take(taker))]
    assert seeds == [0] * 2 * RUNS_IN_A_ROW


def test_a_cluster_gets_rows_and_at_the_end_single_tasks() -> None:
    wanted = tasks(range(3), RUNS_IN_A_ROW + 2)
    rows = in_rows(wanted, 2)
    assert [task for row in rows for task in row] == wanted
    assert [len(row) for row in rows] == [RUNS_IN_A_ROW, 2] * 2 + [1] * (RUNS_IN_A_ROW + 2)
    assert all(len({task.seed for task in row}) == 1 for row in rows)
    assert [len(row) for row in in_rows(wanted[:3], 8)] == [1] * 3


def test_at_the_end_a_process_takes_what_another_has_not_begun() -> None:
    queue = TaskQueue(tasks(range(1), RUNS_IN_A_ROW))
    assert [queue.take(taker) is not None for taker in "abc"] == [True] * 3


def test_tasks_that_come_back_are_the_next() -> None:
    queue = TaskQueue(tasks(range(2), 1))
    first = queue.take("a")
    assert first is not None
    queue.put_back([first])
    assert len(queue) == 2
    assert queue.take("b") == first
