"""Make runs in parallel, on a Dask cluster through joblib."""

from __future__ import annotations

import logging
import os
import socket
import threading
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from typing import Any, Protocol
from urllib.parse import urlsplit

from graphnav import GraphnavError, UserError, import_extra
from graphnav.core.interrupts import ctrl_c_later
from graphnav.studies.ablation.execution.local_processes import LocalWorkers, in_rows
from graphnav.studies.ablation.worker import Result, Task

_PATIENCE_S = 5
"""How long a scheduler may take to answer."""


class Workers(Protocol):
    """Makes runs in parallel."""

    @property
    def at_once(self) -> int:
        """The number of runs that are made at once."""

    def perform_all(self, tasks: Iterable[Task], *, one_at_a_time: bool = False) -> Iterator[Result]:
        """Yield what comes of the tasks, in the order in which they are finished."""


class ClusterWorkers:
    """The workers of a Dask cluster; each makes its runs in processes of its own, as a study on one machine does."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address

    @property
    def at_once(self) -> int:
        """The number of runs that are made at once; workers come and go."""
        cores: dict[str, int] = self._client.ncores()
        return max(1, sum(cores.values()))

    def perform_all(self, tasks: Iterable[Task], *, one_at_a_time: bool = False) -> Iterator[Result]:
        """Yield what comes of the tasks, in the order in which they are finished."""
        from joblib import Parallel, delayed, parallel_config

        try:
            with parallel_config("dask", client=self._client):
                parallel = Parallel(
                    -1, return_as="generator_unordered", batch_size=1, pre_dispatch=1 if one_at_a_time else "2*n_jobs"
                )
            groups = [[task] for task in tasks] if one_at_a_time else in_rows(tasks, self.at_once)
            for results in parallel(delayed(_perform_here)(group) for group in groups):
                yield from results
        except TimeoutError as error:
            what = f"the cluster at {self._address} has no worker"
            raise GraphnavError(f"{what}\n  start one: dask worker {self._address}") from error
        except CancelledError as error:
            raise GraphnavError(f"the cluster at {self._address} is gone") from error


@contextmanager
def cluster_workers(address: str) -> Iterator[Workers]:
    """Let the Dask cluster whose scheduler is at ``address`` make the runs.

    Raises
    ------
    UserError
        Dask is not installed, or no scheduler answers there.
    """
    distributed = import_extra("distributed", "cluster", "--cluster", "Dask")
    for name in logging.root.manager.loggerDict:
        if name.startswith("distributed"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # errors are reported once, by graphnav
    with ExitStack() as closing:
        try:
            _knock(address)
            with ctrl_c_later():  # a client that is made half cannot be closed
                client = closing.enter_context(distributed.Client(address, timeout=_PATIENCE_S, set_as_default=False))
        except (OSError, ValueError) as error:
            hint = "give the address that 'dask scheduler' prints, as tcp://host:8786"
            raise UserError.of(f"--cluster {address}: no scheduler answers there", hint) from error
        yield ClusterWorkers(client, address)


def _knock(address: str) -> None:
    """Raise OSError or ValueError where no scheduler listens: a Dask client would try for long."""
    parts = urlsplit(address)
    if not parts.hostname or not parts.port:
        raise ValueError(address)
    socket.create_connection((parts.hostname, parts.port), timeout=_PATIENCE_S).close()


def _perform_here(tasks: Sequence[Task]) -> list[Result]:
    """Make runs in the process of this thread of a cluster's worker; it ends with the worker, or when idle."""
    if not hasattr(_OF_THREAD, "workers"):
        # Dask lets its own processes return all freed memory at once; a run would take new pages for every picture.
        os.environ.pop("MALLOC_TRIM_THRESHOLD_", None)
        _OF_THREAD.workers = LocalWorkers(1)
    results: list[Result] = []
    try:
        results += _OF_THREAD.workers.perform_all(tasks)
    except GraphnavError as error:
        results.append(Result(tasks[0], {}, error=str(error)))
    return results


_OF_THREAD = threading.local()
