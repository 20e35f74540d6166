"""The Gymnasium environment: episodes of a graph with an agent in it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, get_type_hints

import gymnasium
import numpy as np

from graphnav import BaseLimits, Graph, GraphnavError, Map, Message, PictureContext, State, Twist, UserError
from graphnav.arrays import Bytes, Doubles
from graphnav.core.api import KeptFolder, one_blas_thread
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Channel
from graphnav.core.pictures import Pictures
from graphnav.core.runner import Lockstep, Outcome
from graphnav.learning.agent import FILE, agent_source, graph_with_agent
from graphnav.learning.episode import Episode, Newest, channel_of
from graphnav.learning.interface import Interface
from graphnav.learning.progress import Progress
from graphnav.learning.reward import Function, Reward, Transition
from graphnav.learning.spaces import Actions, Observations, twist_bounds

_MAX_SEED = 2**32
_LOOK_TICKS = 50
"""Ticks of the graph as it is, within which every channel of an agent has to have a message."""
_VIEW_PX = 480


@dataclass(frozen=True)
class EnvOptions:
    """How a graph becomes an environment: the parameters of `make_env`, once they are read."""

    interface: Interface
    reward: Mapping[str, float] | Function | None
    record: Path | None
    render_mode: str | None
    skips: bool
    normalized: bool
    catalog: Catalog


class GraphEnv(gymnasium.Env[Any, Any]):
    """Episodes of a graph in which an agent takes the place of a stage; `graphnav.make_env` makes it.

    An error of a stage within `step` is a `GraphnavError`, and ends the episode.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012 - of an object, too

    def __init__(self, graph: Graph, options: EnvOptions) -> None:
        self.render_mode = options.render_mode
        self._catalog, self._record = options.catalog, options.record
        self._reward = Reward(graph, options.reward)
        self._interface = options.interface
        self._state, self._map = channel_of(graph, State), channel_of(graph, Map)
        if self._reward.needs_progress and (self._state is None or self._map is None):
            raise UserError.of(
                f"reward: {graph.path.stem} has a world without state and map, so there is no progress_m",
                "give another reward",
            )
        self._cleanup = ExitStack()
        self._cleanup.enter_context(one_blas_thread())
        plugin = self._agent_file() if options.record is not None else None
        wanted = self._reward.stages
        self._graph = graph_with_agent(graph, options.interface, wanted, skips=options.skips, plugin=plugin)
        seen, rate_hz = _first_messages(graph, options.interface)
        self._observations = Observations(options.interface, seen)
        acts = options.interface.acts
        bounds = _bounds(graph, acts, seen)
        self._actions = Actions(acts, seen.get(acts.ref), bounds, normalized=options.normalized)
        self.observation_space, self.action_space = self._observations.space, self._actions.space
        self.metadata = {**GraphEnv.metadata, "render_fps": max(1, round(rate_hz))}
        self._episode: Episode | None = None
        self._n_episodes = 0
        self._observation: Any = None
        self._metrics: dict[str, float] = {}
        self._progress: Progress | None = None
        self._path: list[tuple[float, float]] = []

    @property
    def graph(self) -> Graph:
        """The graph of the episodes, with the agent in it."""
        return self._graph

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in the world that ``graphnav run --seed`` draws; without a seed in the next of `np_random`.

        ``options`` are not used. A recorded episode that has not ended is ended as stopped.

        Raises
        ------
        UserError
            The seed is not from 0 to 2**32 - 1.
        GraphnavError
            A stage failed before the agent was asked, or the episode ended before.
        """
        _check_seed(seed)
        super().reset(seed=seed, options=options)
        drawn = int(self.np_random.integers(_MAX_SEED)) if seed is None else int(seed)
        self._end_episode()
        self._path, self._progress, self._metrics = [], None, {}
        graph = replace(self._graph, run=replace(self._graph.run, seed=drawn))
        self._episode = episode = Episode(graph, self._interface.acts.stage, self._watched, self._next_folder())
        inputs = episode.advance(None)
        if inputs is None or episode.outcome:
            self._close_record()
            what = f"the episode of seed {drawn} ended ({episode.outcome}) before the agent was asked"
            raise GraphnavError(f"{what}\n  observe channels that come together, or use another seed")
        self._observation = self._observations.read(inputs)
        self._look()
        self._metrics = episode.metrics(self._counted)
        return self._observation, self._info(0.0)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Let the agent act, and go on to where it is asked again.

        Raises
        ------
        UserError
            The action is not of the space's form or not finite, or the episode has not begun, or has ended.
        GraphnavError
            A stage failed: the episode has ended.
        """
        episode = self._episode
        if episode is None or episode.outcome:
            said = "has ended" if episode is not None else "has not begun"
            raise UserError.of(f"step: the episode {said}", "call reset first")
        message = self._actions.message(action)
        before, last = self._observation, self._metrics
        try:
            inputs = episode.advance(message)
            if inputs is not None:
                self._observation = self._observations.read(inputs)
            progress_m = self._look()
            self._metrics = episode.metrics(None if episode.outcome else self._counted)
        except GraphnavError:
            episode.outcome = episode.outcome or "failed"
            self._close_record()
            raise
        moved = Transition(before, action, self._observation, self._metrics, progress_m, episode.outcome, episode.utime)
        reward = self._reward.of(moved, last)
        truncated = moved.outcome == Outcome.TIMEOUT
        terminated = moved.outcome not in ("", Outcome.TIMEOUT)
        if moved.outcome:
            self._close_record()
        return self._observation, reward, terminated, truncated, self._info(progress_m)

    def render(self) -> Bytes | None:
        """Return the world from above with the robot and its path, uint8 (rows, cols, 3); None without a render mode.

        Raises
        ------
        UserError
            No episode has begun, or its world has no map.
        """
        if self.render_mode is None:
            return None
        world = self._newest(self._map)
        if self._episode is None or world is None:
            raise UserError.of("render: no episode with a map has begun", "call reset first")
        messages = {Map: world, State: self._newest(self._state)}
        context = PictureContext(
            rows=_VIEW_PX,
            cols=_VIEW_PX,
            find=messages.get,
            path_m=lambda: _points(self._path),
        )
        return self._pictures.draw(messages[State] or world, context)

    def close(self) -> None:
        """End the episode and its record, and close the stages."""
        try:
            self._end_episode()
        finally:
            self._cleanup.close()

    @cached_property
    def _pictures(self) -> Pictures:
        return Pictures(self._catalog)

    @property
    def _watched(self) -> list[Channel]:
        needed = self._reward.needs_progress or self.render_mode is not None
        return [channel for channel in (self._state, self._map) if channel is not None] if needed else []

    @property
    def _counted(self) -> frozenset[str] | None:
        """The scores whose metrics are read at every step; None for all."""
        return None if self._reward.needs_all else self._reward.stages

    def _newest(self, channel: Channel | None) -> Any:
        return None if self._episode is None or channel is None else self._episode.newest(channel.ref)

    def _look(self) -> float:
        """Look where the robot is; return its progress, metres."""
        if not self._watched:
            return 0.0
        state = self._newest(self._state)
        if self.render_mode is not None and state is not None:
            self._path.append((state.x_m, state.y_m))
        if not self._reward.needs_progress or state is None:
            return 0.0
        if self._progress is None:
            self._progress = Progress(self._newest(self._map))
        return self._progress.advance(state)

    def _info(self, progress_m: float) -> dict[str, Any]:
        assert self._episode is not None
        seed = self._episode.schedule.graph.run.seed
        outcome, utime = self._episode.outcome, self._episode.utime
        return {
            "utime": utime,
            "seed": seed,
            "outcome": outcome,
            "progress_m": progress_m,
            "metrics": dict(self._metrics),
        }

    def _agent_file(self) -> Path:
        """Return the file with the agent's stage, which is copied into the folder of every episode."""
        folder = KeptFolder.temporary()
        self._cleanup.callback(lambda: folder)  # which removes it with the environment
        path = folder.path / FILE
        path.write_text(agent_source(self._interface), encoding="utf-8")
        return path

    def _next_folder(self) -> Path | None:
        """Make and return the folder of an episode: the first number that no other one, of any process, has."""
        if self._record is None:
            return None
        while True:
            folder = self._record / f"{self._n_episodes:04}"
            try:
                folder.mkdir(parents=True)
            except FileExistsError:
                self._n_episodes += 1
            except OSError as error:
                what = f"record: cannot make {folder}: {error.strerror}"
                raise UserError.of(what, "choose another folder") from error
            else:
                return folder

    def _end_episode(self) -> None:
        episode, self._episode = self._episode, None
        if episode is not None and not episode.is_closed:
            episode.close()

    def _close_record(self) -> None:
        """Complete the record of an episode that has ended; what can still be drawn stays."""
        if self._episode is not None:
            self._episode.close()


def _check_seed(seed: object) -> None:
    if seed is not None and (
        isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < _MAX_SEED
    ):
        raise UserError.of(f"reset: the seed is {seed!r}", f"give an integer from 0 to {_MAX_SEED - 1}, or None")


def _points(path: list[tuple[float, float]]) -> Doubles:
    return np.array(path, np.float64).reshape(-1, 2)


def _first_messages(graph: Graph, interface: Interface) -> tuple[dict[str, Any], float]:
    """Return, of the graph as it is, a message of each channel of an agent, the limits of the base, ticks a second."""
    limits = channel_of(graph, BaseLimits)
    observed = [one.channel for one in interface.observed]
    needs_sample = any(kind is not float for kind in _kinds(interface.acts.message))
    acts = [interface.acts] if needs_sample else []
    wanted = {channel.ref: channel for channel in (*observed, *acts, *([] if limits is None else [limits]))}
    newest = Newest(list(wanted.values()))
    stages = graph.make_stages(also_read=wanted)
    lockstep = Lockstep(graph, stages, [newest])
    stamps: list[int] = []
    try:
        lockstep.reset(graph.run.seed)
        found: dict[str, Any] = {}
        while len(stamps) < _LOOK_TICKS and len(found) < len(wanted):
            stamps.append(lockstep.next_utime)
            ended = lockstep.tick()
            found = {ref: message for ref in wanted if (message := newest(ref)) is not None}
            if ended:
                break
        period_us = (lockstep.next_utime - stamps[0]) / len(stamps)
    finally:
        lockstep.engine.close()
    missing = [ref for ref in wanted if ref not in found and (limits is None or ref != limits.ref)]
    if missing:
        what = f"'{missing[0]}' has no message within {len(stamps)} ticks of seed {graph.run.seed}"
        raise UserError.of(what, "observe another channel")
    return found, 1e6 / period_us


def _kinds(message: type[Message]) -> list[Any]:
    hints = get_type_hints(message)
    return [hints[name] for name in message.__dataclass_fields__]


def _bounds(graph: Graph, acts: Channel, seen: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Return the bounds of the action's fields that something declares."""
    if acts.message is not Twist:
        return {}
    limits = channel_of(graph, BaseLimits)
    guards: dict[str, float] = {}
    for node in graph.nodes:
        if node.stage_class.is_guard:
            guards |= {name: node.params[name] for name in ("max_speed_mps", "max_turn_radps") if node.params.get(name)}
    return twist_bounds(None if limits is None else seen.get(limits.ref), guards)
