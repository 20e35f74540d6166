"""Processes that need not wait for work, and what becomes of the work of one that dies."""

from __future__ import annotations

from collections import deque
from multiprocessing.connection import Pipe
from pathlib import Path
from typing import ClassVar

import pytest

from graphnav.core.errors import GraphnavError
from graphnav.studies.ablation.execution import local_processes
from graphnav.studies.ablation.execution.local_processes import LocalWorkers
from graphnav.studies.ablation.worker import Result, Task


class InstantProcess:
    """A process that has made a run as soon as it is given it, or dies of it."""

    made: ClassVar[list[InstantProcess]] = []
    deadly: ClassVar[str] = ""

    def __init__(self) -> None:
        self.connection, self._theirs = Pipe()
        self.tasks: list[Task] = []
        self.pending: deque[Task] = deque()
        self.is_fresh, self.max_pending = True, 0
        self.made.append(self)

    def send(self, task: Task, scratch: str) -> None:
        assert Path(scratch).is_dir()
        self.tasks.append(task)
        self.pending.append(task)
        self.max_pending = max(self.max_pending, len(self.pending))
        self._theirs.send("done")

    def receive(self) -> Result | None:
        self.connection.recv()
        task = self.pending.popleft()
        return None if task.folder == self.deadly else Result(task, {})

    def kill(self) -> None:
        self.connection.close()
        self._theirs.close()


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> list[InstantProcess]:
    monkeypatch.setattr(InstantProcess, "made", [])
    monkeypatch.setattr(local_processes, "WorkerProcess", InstantProcess)
    return InstantProcess.made


def tasks(count: int) -> list[Task]:
    return [Task(f"runs/a/{seed}", "stages: {}", "a.yaml", (), seed, (), {}) for seed in range(count)]


def test_every_process_has_its_next_run_in_time(processes: list[InstantProcess], tmp_path: Path) -> None:
    workers, wanted = LocalWorkers(2, tmp_path), tasks(9)
    for made, _ in enumerate(workers.perform_all(wanted), 1):
        pending = [len(process.pending) for process in processes]
        if made < 5:
            assert pending == [2, 2]
    assert sorted((task for process in processes for task in process.tasks), key=lambda task: task.seed) == wanted
    assert [process.max_pending for process in processes] == [2, 2]
    assert not list(tmp_path.iterdir())
    workers.close()


def test_of_few_tasks_no_process_has_two(processes: list[InstantProcess], tmp_path: Path) -> None:
    workers = LocalWorkers(4, tmp_path)
    assert len(list(workers.perform_all(tasks(4)))) == 4
    assert [process.max_pending for process in processes] == [1] * 4
    assert len(list(workers.perform_all(tasks(1)))) == 1
    assert len(processes) == 4
    workers.close()


def test_what_a_dead_process_had_not_begun_is_made_by_another(
    processes: list[InstantProcess], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(InstantProcess, "deadly", "runs/a/0")
    workers, wanted = LocalWorkers(2, tmp_path), tasks(8)
    results = list(workers.perform_all(wanted))
    assert sorted(result.task.seed for result in results) == list(range(8))
    assert [result.task.folder for result in results if result.died] == ["runs/a/0"]
    assert len(processes) == 3
    assert processes[0].tasks[1] in [*processes[1].tasks, *processes[2].tasks]
    workers.close()


def test_one_at_a_time(processes: list[InstantProcess], tmp_path: Path) -> None:
    workers = LocalWorkers(3, tmp_path)
    assert len(list(workers.perform_all(tasks(5), one_at_a_time=True))) == 5
    assert len(processes) == 1
    workers.close()


def test_without_a_place_to_work_the_study_ends(processes: list[InstantProcess], tmp_path: Path) -> None:
    workers = LocalWorkers(1, tmp_path / "gone")
    with pytest.raises(GraphnavError, match=r"^cannot work in .*gone: .*No such file or directory"):
        list(workers.perform_all(tasks(1)))
    assert len(processes) == 1
    workers.close()
