"""A process that steps several worlds: ``python -m graphnav.learning.worker DESCRIPTOR``, started by a vector env.

It is told what to do by a connection, and ends with it; observations and actions are in shared memory.
"""

from __future__ import annotations

import mmap
import pickle
import signal
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
_ALIGN = 64
ALONE = ""
"""The name of the only array of an observation or an action."""
OBSERVED, ACTED = "observed", "acted"
REWARD, TERMINATED, TRUNCATED = "reward", "terminated", "truncated"


@dataclass(frozen=True)
class Layout:
    """The arrays of all worlds in shared memory: by what they are and their name, the shape of one and its type."""

    n: int
    arrays: Mapping[tuple[str, str], tuple[tuple[int, ...], str]]

    @property
    def n_bytes(self) -> int:
        """The size of the memory."""
        return sum(self._size(shape, dtype) for shape, dtype in self.arrays.values())

    def views(self, memory: mmap.mmap) -> dict[tuple[str, str], Array]:
        """Return the arrays, (n, ...) each."""
        found, at = {}, 0
        for key, (shape, dtype) in self.arrays.items():
            count = int(np.prod((self.n, *shape)))
            found[key] = np.frombuffer(memory, dtype, count, at).reshape(self.n, *shape)
            at += self._size(shape, dtype)
        return found

    def _size(self, shape: tuple[int, ...], dtype: str) -> int:
        n_bytes = int(np.prod((self.n, *shape))) * np.dtype(dtype).itemsize
        return -(-n_bytes // _ALIGN) * _ALIGN


@dataclass(frozen=True)
class Job:
    """The order to a worker: worlds ``places`` of a graph, for a request that cloudpickle has packed."""

    graph: bytes
    path: Path
    plugins: tuple[Path, ...]
    request: bytes
    places: tuple[int, ...]
    layout: Layout
    memory_fd: int


class Worlds:
    """The worlds of a worker."""

    def __init__(self, job: Job) -> None:
        from graphnav.core.catalog import Catalog  # noqa: PLC0415 - after the search path is that of the parent
        from graphnav.core.graph import graph_of  # noqa: PLC0415
        from graphnav.core.trust import Trust  # noqa: PLC0415

        self._places = job.places
        memory = mmap.mmap(job.memory_fd, job.layout.n_bytes)
        self._arrays = job.layout.views(memory)
        request = pickle.loads(job.request)  # noqa: S301 - the parent has packed it
        catalog = Catalog(Trust(runs_all=True)).add_files(job.plugins)
        graph = graph_of(job.graph, job.path, catalog, replaced=[plugin.name for plugin in job.plugins])
        graph = replace(graph, plugins=job.plugins)
        self._envs = [request.for_world(place).env(graph, catalog) for place in job.places]
        self._has_ended = [False] * len(self._envs)

    def reset(self, seeds: list[int | None]) -> list[dict[str, Any]]:
        """Reset every world; return their infos."""
        infos = []
        for k, (env, seed) in enumerate(zip(self._envs, seeds, strict=True)):
            observation, info = env.reset(seed=seed)
            self._put(k, observation, 0.0, terminated=False, truncated=False)
            infos.append(info)
        return infos

    def step(self) -> list[dict[str, Any]]:
        """Step every world with its action; one whose episode has ended is reset instead."""
        infos = []
        for k, env in enumerate(self._envs):
            if self._has_ended[k]:
                observation, info = env.reset()
                self._put(k, observation, 0.0, terminated=False, truncated=False)
            else:
                observation, reward, terminated, truncated, info = env.step(self._action(self._places[k]))
                self._put(k, observation, float(reward), terminated=terminated, truncated=truncated)
            infos.append(info)
        return infos

    def render(self) -> list[Any]:
        """Return the picture of every world."""
        return [env.render() for env in self._envs]

    def close(self) -> None:
        """Close every world."""
        for env in self._envs:
            env.close()

    def _action(self, place: int) -> Any:
        parts = {name: array[place].copy() for (kind, name), array in self._arrays.items() if kind == ACTED}
        return parts.get(ALONE, parts)

    def _put(self, k: int, observation: Any, reward: float, *, terminated: bool, truncated: bool) -> None:
        place = self._places[k]
        self._has_ended[k] = terminated or truncated
        for (kind, name), array in self._arrays.items():
            if kind == OBSERVED:
                array[place] = observation if name == ALONE else observation[name]
        for kind, value in ((REWARD, reward), (TERMINATED, terminated), (TRUNCATED, truncated)):
            self._arrays[kind, ALONE][place] = value


def serve(link: Any) -> None:
    """Do what the parent says until it closes the connection; answer each with ``(worked, result)``."""
    sys.path[:] = link.recv()
    job: Job = link.recv()
    worlds: Worlds | None = None
    try:
        while True:
            try:
                if worlds is None:
                    worlds, result = Worlds(job), None
                else:
                    order, *given = link.recv()
                    result = getattr(worlds, order)(*given)
                answer = (True, result)
            except (EOFError, ConnectionError):
                return
            except Exception as error:  # noqa: BLE001 - the parent raises it
                answer = (False, str(error) if _is_ours(error) else f"{type(error).__name__}: {error}")
            with suppress(ConnectionError):  # a parent that is gone is noticed by the next order
                link.send(answer)
            if not answer[0]:
                return
    finally:
        if worlds is not None:
            worlds.close()


def _is_ours(error: Exception) -> bool:
    from graphnav import GraphnavError  # noqa: PLC0415

    return isinstance(error, GraphnavError)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    serve(Connection(int(sys.argv[1])))
