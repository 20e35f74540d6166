"""``graphnav.make_env`` and ``graphnav.make_vec_env``: environments for learners."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from graphnav import Graph, UserError, import_extra
from graphnav.core.api import Argument, PathLike, Shared, loaded, with_run_options
from graphnav.core.catalog import Catalog
from graphnav.core.graph import resolved_yaml
from graphnav.core.parameters import Parameter, documented
from graphnav.core.trust import Trust
from graphnav.learning.interface import interface_of
from graphnav.learning.parameters import (
    ACT,
    COUNT,
    NORMALIZED,
    OBSERVE,
    OF_ENV,
    PROCESSES,
    RECORD,
    RENDER_MODE,
    SKIP,
    TIME_LIMIT_S,
    TRUTH,
)

if TYPE_CHECKING:
    import gymnasium

    from graphnav.learning.reward import Transition

_EXTRA = "gym"
_MAX_WORLDS = 4096
RewardArgument = Mapping[str, float] | Callable[["Transition"], float]


@documented(Shared.GRAPH, Shared.SET, Shared.PLUGINS, *OF_ENV)
def make_env(
    graph: PathLike | Graph,
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    observe: str | Sequence[str] | None = None,
    act: str | None = None,
    reward: RewardArgument | None = None,
    time_limit_s: float | None = None,
    record: PathLike | None = None,
    render_mode: Literal["rgb_array"] | None = None,
    plugins: Sequence[PathLike] = (),
    truth: bool = False,
    skip: bool = True,
    normalized: bool = False,
) -> gymnasium.Env[Any, Any]:
    """Return a Gymnasium environment: the world of a graph, and of its stages those that the agent does not replace.

    ``reset(seed=...)`` draws the world that ``graphnav run --seed`` draws, and what the channels hold is byte for byte
    what that run publishes with the same actions. The agent is asked when all channels that it observes have a message
    of one stamp; ticks in which they have not pass without it. What follows from its action is sampled, as by
    `graphnav.Latest`. The last tick of an episode, that of the outcome or the time limit, has an observation and no
    action.

    ``info`` has ``utime`` (simulated microseconds), ``seed``, ``outcome`` ("" while the episode goes on),
    ``progress_m`` and ``metrics``: those that the reward counts at every step, all at the end, as measured so far.
    Needs the extra ``gym``.

    Raises
    ------
    UserError
        All errors of the graph and the arguments, or Gymnasium is not installed.
    """
    _require_gymnasium("graphnav.make_env")
    checked, catalog = _loaded(graph, set, plugins, time_limit_s)
    return EnvRequest.of(observe, act, reward, record, render_mode, truth=truth, skip=skip, normalized=normalized).env(
        checked, catalog
    )


@documented(Shared.GRAPH, COUNT, PROCESSES, Shared.SET, Shared.PLUGINS, *OF_ENV)
def make_vec_env(
    graph: PathLike | Graph,
    n: int,
    *,
    processes: int = 2,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    observe: str | Sequence[str] | None = None,
    act: str | None = None,
    reward: RewardArgument | None = None,
    time_limit_s: float | None = None,
    record: PathLike | None = None,
    render_mode: Literal["rgb_array"] | None = None,
    plugins: Sequence[PathLike] = (),
    truth: bool = False,
    skip: bool = True,
    normalized: bool = False,
) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """Return a vector environment of ``n`` worlds of a graph, which step in processes of their own.

    Each world is an environment as `make_env` makes it; observations and actions are in memory that the processes
    share. An episode that has ended begins again with the next step (``AutoresetMode.NEXT_STEP``). ``reset`` takes a
    seed for the first world, which the others count on from, or a list of them. A script needs no
    ``if __name__ == "__main__":``. A function as reward is sent to the processes by cloudpickle. ``record``: the worlds
    have a folder each in it.

    The processes end with `close`, with the environment, and with this process, however that ends. If one of them ends
    before, the call that waits for it raises `GraphnavError`, and all are ended.

    Raises
    ------
    UserError
        As of `make_env`.
    GraphnavError
        A process does not start.
    """
    _require_gymnasium("graphnav.make_vec_env")
    from graphnav.learning.vector_env import GraphVectorEnv  # noqa: PLC0415 - imports Gymnasium, an extra

    for value, parameter in ((n, COUNT), (processes, PROCESSES)):
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= _MAX_WORLDS:
            raise Argument(value, parameter).error(f"an integer from 1 to {_MAX_WORLDS}")
    checked, catalog = _loaded(graph, set, plugins, time_limit_s)
    request = EnvRequest.of(observe, act, reward, record, render_mode, truth=truth, skip=skip, normalized=normalized)
    return GraphVectorEnv(checked, catalog, request, n, min(processes, n))


@dataclass(frozen=True)
class EnvRequest:
    """The arguments of an environment, checked for their types; it can be sent to another process."""

    observe: tuple[str, ...] | None
    act: str | None
    reward: RewardArgument | None
    record: Path | None
    render_mode: str | None
    truth: bool
    skip: bool
    normalized: bool

    @classmethod
    def of(
        cls,
        observe: object,
        act: object,
        reward: Any,
        record: PathLike | None,
        render_mode: object,
        *,
        truth: object,
        skip: object,
        normalized: object,
    ) -> EnvRequest:
        """Return the arguments; raises UserError for one of a wrong type."""
        words = None if observe is None else (observe,) if isinstance(observe, str) else observe
        Argument(act, ACT).check_text()
        if render_mode not in (None, "rgb_array"):
            raise Argument(render_mode, RENDER_MODE).error('"rgb_array" or None')
        for value, parameter in ((truth, TRUTH), (skip, SKIP), (normalized, NORMALIZED)):
            if not isinstance(value, bool):
                raise Argument(value, parameter).error("True or False")
        return cls(
            None if words is None else Argument(words, OBSERVE).texts(),
            None if act is None else str(act),
            reward,
            None if record is None else Argument(record, RECORD).path().absolute(),
            None if render_mode is None else str(render_mode),
            bool(truth),
            bool(skip),
            bool(normalized),
        )

    def without_record(self) -> EnvRequest:
        """Return the same without a record."""
        return replace(self, record=None)

    def for_world(self, place: int) -> EnvRequest:
        """Return the same for one of several worlds, which records into a folder of its own."""
        return self if self.record is None else replace(self, record=self.record / f"world_{place:02}")

    def env(self, graph: Graph, catalog: Catalog) -> gymnasium.Env[Any, Any]:
        """Return the environment; raises UserError for what the graph does not have."""
        from graphnav.learning.graph_env import EnvOptions, GraphEnv  # noqa: PLC0415 - imports Gymnasium, an extra

        interface = interface_of(graph, self.observe, self.act, truth=self.truth)
        options = EnvOptions(interface, self.reward, self.record, self.render_mode, self.skip, self.normalized, catalog)
        return GraphEnv(graph, options)


def graph_text(graph: Graph) -> bytes:
    """Return a graph so that another process on this machine loads it."""
    return resolved_yaml(graph, portable_paths=False).encode()


def _require_gymnasium(who: str) -> None:
    import_extra("gymnasium", _EXTRA, who)


def _loaded(
    graph: PathLike | Graph, sets: Mapping[str, object] | None, plugins: Sequence[PathLike], time_limit_s: object
) -> tuple[Graph, Catalog]:
    """Return the graph with the time limit, and the catalog of its stages."""
    _check_seconds(time_limit_s, TIME_LIMIT_S)
    catalog = Catalog(Trust(runs_all=True))
    checked = loaded(graph, sets, plugins, catalog)
    if isinstance(graph, Graph):
        catalog.add_files(graph.plugins)
    return with_run_options(checked, {"until_s": time_limit_s}, {"until_s": TIME_LIMIT_S.name}), catalog


def _check_seconds(value: object, parameter: Parameter) -> None:
    if value is None:
        return
    Argument(value, parameter).check_number()
    if not (isinstance(value, int | float) and 0 < value < math.inf):
        raise UserError.of(f"{parameter.name} is {value}, but must be above 0", parameter.hint)
