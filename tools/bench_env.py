"""Benchmark steps of environments: alone, by Gymnasium's processes and by ours, beside ticks of a run without a log.

All drive by the commands of one run, so that they meet the same pictures, and take turns. Steps of a vector are those
of all of its worlds together.
"""

from __future__ import annotations

import argparse
import functools
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AsyncVectorEnv
from taking_turns import Turns, load_told, take_turns

import graphnav
from graphnav.arrays import Doubles
from graphnav.core.api import one_thread
from graphnav.core.runner import Lockstep

SEED = 1000
RUN = "graphnav run, no log"


class Ticks:
    """A run without a log that begins again when it has ended."""

    def __init__(self, graph: str) -> None:
        self._graph = graphnav.load(graph)
        self._begin()

    def _begin(self) -> None:
        self._lockstep = Lockstep(self._graph, self._graph.make_stages(), [])
        self._lockstep.reset(SEED)

    def cost(self, n: int) -> float:
        """Return the time of a tick, s; the beginning does not count."""
        spent = 0.0
        for _ in range(n):
            begin = time.perf_counter()
            ended = self._lockstep.tick()
            spent += time.perf_counter() - begin
            if ended or self._lockstep.next_utime > 1e6 * (self._graph.run.until_s or 1e9):
                self._begin()
        return spent / n


class Steps:
    """An environment, or a vector of them, that is driven by given commands again and again."""

    def __init__(self, env: Any, actions: Doubles) -> None:
        self.env, self._actions = env, actions
        self._n_worlds = getattr(env, "num_envs", 0)
        self._begin()

    def _begin(self) -> None:
        seeds: Any = [SEED] * self._n_worlds if self._n_worlds else SEED
        self.env.reset(seed=seeds)
        self._place = 0

    def cost(self, n: int) -> float:
        """Return the time of a step of one world, s; the beginning does not count."""
        spent = 0.0
        for _ in range(n):
            action = self._actions[self._place].astype(np.float32)
            given = np.tile(action, (self._n_worlds, 1)) if self._n_worlds else action
            begin = time.perf_counter()
            result = self.env.step(given)
            spent += time.perf_counter() - begin
            self._place += 1
            if self._place == len(self._actions) or np.any(result[2]) or np.any(result[3]):
                self._begin()
        return spent / n / max(1, self._n_worlds)


def commands(graph: str, act: str) -> Doubles:
    """Return what a stage commands in a run, (n, 2): zeros where it is not asked."""
    run = graphnav.run(graph, seed=SEED, until_s=30.0, pictures=False)
    given = {round(at_s * 1e6): (one.v_mps, one.omega_radps) for at_s, one in run.log.messages(f"{act}.twist")}
    stamps = [round(at_s * 1e6) for at_s, _ in run.log.messages("robot.image")]
    return np.array([given.get(stamp, (0.0, 0.0)) for stamp in stamps[:-1]])


def measure(graph: str, act: str, rounds: int, n: int) -> Turns:
    """Return the time of a step of each rival, s."""
    actions = commands(graph, act)
    factory = functools.partial(graphnav.make_env, graph, act=act)
    made: dict[str, Any] = {
        "make_env": factory(),
        "make_env, all stages": factory(skip=False),
        "AsyncVectorEnv, 2 worlds": AsyncVectorEnv([factory] * 2),
        "make_vec_env, 2 worlds": graphnav.make_vec_env(graph, 2, act=act),
        "make_vec_env, 8 worlds": graphnav.make_vec_env(graph, 8, act=act),
    }
    rivals: dict[str, Callable[[], float]] = {RUN: functools.partial(Ticks(graph).cost, n)}
    rivals |= {name: functools.partial(Steps(env, actions).cost, n) for name, env in made.items()}
    try:
        return take_turns(rivals, rounds)
    finally:
        for env in made.values():
            env.close()


def main(words: Sequence[str] | None = None) -> int:
    """Print steps a second of each rival, and the ratio to a run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("graph", nargs="?", default="corridor_ccw")
    parser.add_argument("--act", default="control")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=40)
    args = parser.parse_args(words)
    with one_thread():
        turns = measure(args.graph, args.act, args.rounds, args.steps)
    for name in turns.costs:
        ratio = "" if name == RUN else f"   {turns.ratio(RUN, name)} of a run's"
        sys.stdout.write(f"{name:26} {1 / turns.median(name):8.0f} steps/s{ratio}\n")
    return 0


if __name__ == "__main__":
    with load_told():
        sys.exit(main())
