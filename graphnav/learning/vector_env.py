"""Many worlds at a time, in worker processes that share memory with this one."""

from __future__ import annotations

import mmap
import os
import subprocess
import sys
import weakref
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from typing import Any

import cloudpickle
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from graphnav import Graph, GraphnavError, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.errors import one_line
from graphnav.core.machine import ONE_THREAD, environment_alike
from graphnav.learning import worker
from graphnav.learning.make_env import EnvRequest, graph_text
from graphnav.learning.spaces import checked_array
from graphnav.learning.worker import ACTED, ALONE, OBSERVED, REWARD, TERMINATED, TRUNCATED, Job, Layout

_PATIENCE_S = 5.0
"""How long a process may take to close its worlds."""
_MAX_SEED = 2**32


class GraphVectorEnv(VectorEnv[Any, Any, Any]):
    """Worlds that step in processes of their own; `graphnav.make_vec_env` makes it."""

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012 - of an object, too

    def __init__(self, graph: Graph, catalog: Catalog, request: EnvRequest, n: int, processes: int) -> None:
        self.num_envs, self.render_mode = n, request.render_mode
        self._workers: list[_Worker] = []
        self._end = weakref.finalize(self, _end_all, self._workers)
        model = request.without_record().env(graph, catalog)
        self.metadata = {**model.metadata, **GraphVectorEnv.metadata}
        self.single_observation_space, self.single_action_space = model.observation_space, model.action_space
        model.close()
        self.observation_space = batch_space(self.single_observation_space, n)
        self.action_space = batch_space(self.single_action_space, n)
        layout = _layout(n, self.single_observation_space, self.single_action_space)
        memory_fd = os.memfd_create("graphnav-worlds", os.MFD_CLOEXEC)
        try:
            os.ftruncate(memory_fd, layout.n_bytes)
            self._arrays = layout.views(mmap.mmap(memory_fd, layout.n_bytes))
            packed, text = _packed(request), graph_text(graph)
            places = [tuple(part.tolist()) for part in np.array_split(np.arange(n), processes)]
            for number, mine in enumerate(places):
                self._workers.append(_Worker(number, mine, memory_fd))
                self._workers[-1].send(sys.path)
                self._workers[-1].send(Job(text, graph.path, graph.plugins, packed, mine, layout, memory_fd))
            self._answers()
        except BaseException:
            self._end()
            raise
        finally:
            os.close(memory_fd)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in every world; ``seed``: of the first, which the others count on from, or one for each.

        ``options`` are not used.

        Raises
        ------
        UserError
            There are more or fewer seeds than worlds, or the environment is closed.
        GraphnavError
            A world failed, or a process ended; all are ended then.
        """
        super().reset(seed=seed if isinstance(seed, int) else None, options=options)
        seeds = _seeds(seed, self.num_envs)
        for one in self._open():
            one.send(("reset", [seeds[place] for place in one.places]))
        infos = self._infos()
        return self._observations(), infos

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Step every world; one whose episode ended with the step before begins the next one instead.

        Raises
        ------
        UserError
            The actions are not of the space's form, or the environment is closed.
        GraphnavError
            A world failed, or a process ended; all are ended then.
        """
        workers = self._open()
        self._put(actions)
        for one in workers:
            one.send(("step",))
        infos = self._infos()
        ends = (self._arrays[kind, ALONE].copy() for kind in (REWARD, TERMINATED, TRUNCATED))
        reward, terminated, truncated = ends
        return self._observations(), reward, terminated, truncated, infos

    def render(self) -> tuple[Any, ...] | None:
        """Return the picture of every world, None without a render mode."""
        if self.render_mode is None:
            return None
        for one in self._open():
            one.send(("render",))
        return tuple(picture for pictures in self._answers() for picture in pictures)

    def close_extras(self, **_: Any) -> None:
        """End the processes."""
        self._end()

    def _open(self) -> list[_Worker]:
        if not self._end.alive:
            raise UserError.of("the vector environment is closed", "make another one")
        return self._workers

    def _infos(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        answers = self._answers()
        for one, infos in zip(self._workers, answers, strict=True):
            for place, info in zip(one.places, infos, strict=True):
                found = self._add_info(found, info, place)
        return found

    def _answers(self) -> list[Any]:
        """Return what every process answers; one that failed ends all."""
        try:
            return [one.receive() for one in self._workers]
        except BaseException:  # also Ctrl-C: what they still answer would be taken for the next answer
            self._end()
            raise

    def _observations(self) -> Any:
        parts = {name: array.copy() for (kind, name), array in self._arrays.items() if kind == OBSERVED}
        return parts.get(ALONE, parts)

    def _put(self, actions: Any) -> None:
        for (kind, name), array in self._arrays.items():
            if kind == ACTED:
                is_named = isinstance(actions, Mapping) and name in actions
                if name != ALONE and not is_named:
                    raise UserError.of(f"the actions have no array '{name}'", "give those of the action space")
                who, given = (
                    ("the array of actions", actions) if name == ALONE else (f"'{name}' of the actions", actions[name])
                )
                array[...] = checked_array(who, given, array.shape)


class _Worker:
    """A process of some worlds as this one sees it."""

    def __init__(self, number: int, places: tuple[int, ...], memory_fd: int) -> None:
        self.places, self._number = places, number
        self._link, theirs = Pipe()
        command = [sys.executable, "-u", "-P", "-m", worker.__name__, str(theirs.fileno())]
        try:
            self._process = subprocess.Popen(  # noqa: S603 - it is this program
                command,
                env=os.environ | ONE_THREAD | environment_alike(),
                stdin=subprocess.DEVNULL,
                stdout=2,
                pass_fds=[theirs.fileno(), memory_fd],
            )
        except OSError as error:
            self._link.close()
            raise GraphnavError(f"a process of worlds cannot be started: {error}") from error
        finally:
            theirs.close()

    def send(self, order: object) -> None:
        """Tell it something; if it has died, `receive` notices."""
        with suppress(OSError):
            self._link.send(order)

    def receive(self) -> Any:
        """Return its answer; raises GraphnavError if a world failed or it has ended."""
        try:
            worked, result = self._link.recv()
        except (EOFError, OSError) as error:
            raise GraphnavError(self._fate()) from error
        if not worked:
            raise GraphnavError(f"{self._worlds()}: {result}")
        return result

    def hang_up(self) -> None:
        """Close the connection, with which it ends."""
        self._link.close()

    def wait(self) -> None:
        """Wait for its end, and enforce it."""
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _fate(self) -> str:
        self.wait()
        status = self._process.returncode
        how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
        return f"process {self._number} of {self._worlds()} {how}"

    def _worlds(self) -> str:
        first, last = self.places[0], self.places[-1]
        return f"world {first}" if first == last else f"worlds {first} to {last}"


def _end_all(workers: list[_Worker]) -> None:
    for one in workers:
        one.hang_up()
    for one in workers:
        one.wait()


def _packed(request: EnvRequest) -> bytes:
    try:
        packed: bytes = cloudpickle.dumps(request)
    except Exception as error:
        what = f"the reward function cannot be sent to other processes: {one_line(error)}"
        raise UserError.of(what, "write it as a function of a module") from error
    return packed


def _layout(n: int, observed: spaces.Space[Any], acted: spaces.Space[Any]) -> Layout:
    arrays: dict[tuple[str, str], tuple[tuple[int, ...], str]] = {}
    for kind, space in ((OBSERVED, observed), (ACTED, acted)):
        for name, box in _boxes(space):
            arrays[kind, name] = (box.shape, np.dtype(box.dtype).str)
    arrays |= {(REWARD, ALONE): ((), "<f8"), (TERMINATED, ALONE): ((), "|b1"), (TRUNCATED, ALONE): ((), "|b1")}
    return Layout(n, arrays)


def _boxes(space: spaces.Space[Any]) -> Iterator[tuple[str, spaces.Box]]:
    for name, box in space.items() if isinstance(space, spaces.Dict) else [(ALONE, space)]:
        assert isinstance(box, spaces.Box)
        yield name, box


def _seeds(seed: object, n: int) -> list[int | None]:
    if seed is None:
        return [None] * n
    if isinstance(seed, int | np.integer) and not isinstance(seed, bool):
        return [(int(seed) + place) % _MAX_SEED for place in range(n)]
    if not isinstance(seed, Sequence | np.ndarray) or isinstance(seed, str) or len(seed) != n:
        raise UserError.of(f"reset: the seeds are {seed!r}", f"give an integer, or a list of {n}")
    return [None if one is None else int(one) for one in seed]
