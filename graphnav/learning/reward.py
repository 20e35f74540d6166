"""The reward of a step: what metrics, progress and the outcome are worth, or a function."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from graphnav import Graph, UserError, did_you_mean
from graphnav.core.runner import Outcome

PROGRESS, STEP = "progress_m", "step"
OUTCOMES = (Outcome.GOAL, Outcome.CONTACT, Outcome.TIMEOUT, Outcome.END)
DEFAULT: Mapping[str, float] = {PROGRESS: 1.0, "goal": 10.0, "contact": -10.0}
"""A metre nearer to the goal is worth 1, or a metre driven where the map has no goal."""


class Transition(NamedTuple):
    """A step, for a reward by a function.

    ``observation``, ``action``, ``next_observation``: as Gymnasium knows them. ``metrics``: of the scores so far, as
    ``stage.metric``. ``progress_m``: by how much the way to the goal has become shorter. ``outcome``: how the episode
    ended with this step, or "". ``utime``: simulated microseconds.
    """

    observation: Any
    action: Any
    next_observation: Any
    metrics: Mapping[str, float]
    progress_m: float
    outcome: str
    utime: int


Function = Callable[[Transition], float]


class Reward:
    """The reward as it was asked for: a table of weights, or a function.

    Raises UserError for a term that the graph does not have, and for a weight that is not a number.
    """

    def __init__(self, graph: Graph, given: Mapping[str, float] | Function | None) -> None:
        table: object = DEFAULT if given is None else given
        if not isinstance(table, Mapping) and not callable(table):
            said = type(given).__name__
            raise UserError.of(f"reward must be a mapping or a function, not {said}", f"write reward={dict(DEFAULT)}")
        self._function: Function | None = None if isinstance(table, Mapping) else table
        self._weights = _weights(graph, table) if isinstance(table, Mapping) else {}
        self.metrics = tuple(name for name in self._weights if "." in name)
        """The metrics that count, as ``stage.metric``."""
        self.needs_all = self._function is not None
        """Whether it may ask for every metric."""
        self.needs_progress = self._function is not None or PROGRESS in self._weights
        """Whether it needs the way to the goal."""

    @property
    def stages(self) -> frozenset[str]:
        """The scores that it needs."""
        return frozenset(name.partition(".")[0] for name in self.metrics)

    def of(self, transition: Transition, before: Mapping[str, float]) -> float:
        """Return the reward of a step; ``before``: the metrics before it.

        A metric counts by its change, where both values are defined.

        Raises
        ------
        UserError
            The function raised, or returned something else than a finite number.
        """
        if self._function is not None:
            return _called(self._function, transition)
        found = self._weights.get(STEP, 0.0) + self._weights.get(transition.outcome, 0.0)
        found += self._weights.get(PROGRESS, 0.0) * transition.progress_m
        for name in self.metrics:
            if name in before and name in transition.metrics:
                found += self._weights[name] * (transition.metrics[name] - before[name])
        return found


def _weights(graph: Graph, table: Mapping[str, Any]) -> dict[str, float]:
    metrics = {f"{stage}.{name}" for stage, declared in graph.metrics.items() for name in declared}
    known = {*metrics, *map(str, OUTCOMES), PROGRESS, STEP}
    for name, weight in table.items():
        if name not in known:
            hint = did_you_mean(str(name), known) or f"terms are {PROGRESS}, {STEP}, {', '.join(OUTCOMES)} and metrics"
            raise UserError.of(f"reward: {graph.path.stem} has no term {name!r}", hint)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not math.isfinite(weight):
            raise UserError.of(f"reward: the weight of '{name}' is {weight!r}", "give a finite number")
    return {name: float(weight) for name, weight in table.items()}


def _called(function: Function, transition: Transition) -> float:
    try:
        reward = float(function(transition))
    except Exception as error:
        raise UserError.of(f"the reward function raised {type(error).__name__}: {error}") from error
    if not math.isfinite(reward):
        raise UserError.of(f"the reward function returned {reward}", "return a finite number")
    return reward
