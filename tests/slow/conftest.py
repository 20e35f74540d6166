"""Fixtures of tests that take minutes to hours: seeds, the number of processes, and drives made once."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path

import pytest
from testbed import drives

from tests.processes.conftest import runs  # noqa: F401 - a fixture

DriveAll = Callable[[str, Sequence[int], tuple[str, ...]], drives.Drives]


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark the tests of this folder."""
    item.add_marker("slow")


@pytest.fixture
def tmp_path(tmp_path: Path) -> Iterator[Path]:
    """Return pytest's folder, which is removed after the test: drives leave gigabytes."""
    yield tmp_path
    shutil.rmtree(tmp_path, ignore_errors=True)


@pytest.fixture(scope="session")
def seeds(pytestconfig: pytest.Config) -> range:
    """Return the seeds of ``--seeds FIRST:END``."""
    first, _, end = str(pytestconfig.getoption("--seeds")).partition(":")
    return range(int(first), int(end))


@pytest.fixture(scope="session")
def jobs(pytestconfig: pytest.Config) -> int:
    """Return the number of drives at a time."""
    return int(pytestconfig.getoption("--jobs"))


@pytest.fixture(scope="session")
def kills(pytestconfig: pytest.Config) -> int:
    """Return how often each stage is killed."""
    return int(pytestconfig.getoption("--kills"))


@pytest.fixture(scope="session")
def minutes(pytestconfig: pytest.Config) -> float:
    """Return how long a run goes on."""
    return float(pytestconfig.getoption("--minutes"))


@pytest.fixture(scope="session")
def drive_all(jobs: int) -> DriveAll:
    """Return a function that drives a graph with some swaps over seeds: once a session."""
    return cache(lambda graph, seeds, sets: drives.drive_all(graph, seeds, sets, jobs))
