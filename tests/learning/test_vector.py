"""Many worlds at a time."""

from __future__ import annotations

import functools
import gc
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv

import graphnav
from graphnav import GraphnavError, UserError
from graphnav.learning.reward import Transition

OPTIONS: dict[str, Any] = {"act": "guard", "time_limit_s": 0.5}
N = 3
SCRIPT = """
import graphnav
vector = graphnav.make_vec_env("corridor_ccw", 1, act="guard", processes=1)
print(vector._workers[0]._process.pid, flush=True)
"""


def workers(vector: Any) -> list[Any]:
    """Return the processes of a vector environment."""
    return [one._process for one in vector._workers]


def is_alive(pid: int) -> bool:
    """Return whether there is such a process, and it is not only waited for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def episodes(vector: Any) -> Iterator[tuple[Any, ...]]:
    """Yield what a vector environment gives over two episodes."""
    rng = np.random.default_rng(0)
    observation, info = vector.reset(seed=[3, 4, 5])
    yield observation, info["seed"]
    for _ in range(8):
        *found, info = vector.step(rng.uniform(-0.3, 0.3, (N, 2)).astype(np.float32))
        yield (*found, info["utime"], info["seed"])


@pytest.fixture(scope="module")
def vector() -> Iterator[Any]:
    """Return worlds in two processes."""
    made = graphnav.make_vec_env("corridor_ccw", N, **OPTIONS)
    yield made
    made.close()


@pytest.mark.long
def test_worlds_in_processes_are_those_of_gymnasiums_vectors(vector: Any) -> None:
    assert vector.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    factory = functools.partial(graphnav.make_env, "corridor_ccw", **OPTIONS)
    rivals = [SyncVectorEnv([factory] * N), AsyncVectorEnv([factory] * N)]
    given = [list(episodes(one)) for one in (vector, *rivals)]
    for rival in rivals:
        rival.close()
    assert vector.single_observation_space == rivals[0].single_observation_space
    assert vector.action_space == rivals[0].action_space
    for ours, *theirs in zip(*given, strict=True):
        for other in theirs:
            for mine, its in zip(ours, other, strict=True):
                if len(ours) == 2 or ours[-1].tolist() == [3, 4, 5]:  # later seeds are drawn, unseeded, by each world
                    assert (mine == its).all()


def test_ended_episodes_begin_anew_with_the_next_step(vector: Any) -> None:
    vector.reset(seed=3)
    for _ in range(5):
        *_, truncated, info = vector.step(vector.action_space.sample())
    assert truncated.all()
    assert info["utime"].tolist() == [500_000] * N
    assert info["outcome"].tolist() == ["timeout"] * N
    _, reward, _, truncated, info = vector.step(vector.action_space.sample())
    assert reward.tolist() == [0.0] * N
    assert not truncated.any()
    assert info["utime"].tolist() == [0] * N


def test_seeds_count_on_from_the_first(vector: Any) -> None:
    assert vector.reset(seed=7)[1]["seed"].tolist() == [7, 8, 9]
    with pytest.raises(UserError, match=r"reset: the seeds are \[1, 2\]"):
        vector.reset(seed=[1, 2])


@pytest.mark.parametrize(
    ("actions", "told"),
    [
        (np.full((N, 2), np.nan), "the actions hold a NaN or an infinity"),
        (np.zeros(2), "the actions have the shape"),
        (["a"] * N, "the actions are of"),
    ],
)
def test_actions_of_another_form_are_refused(vector: Any, actions: Any, told: str) -> None:
    vector.reset(seed=3)
    with pytest.raises(UserError, match=told):
        vector.step(actions)
    vector.step(np.zeros((N, 2)))


def reward_of(one: Transition) -> float:
    """Return the time; 10 fails."""
    if one.utime > 250_000:
        raise ValueError("too late")
    return one.utime * 1e-6


@pytest.mark.long
def test_a_world_that_fails_ends_all() -> None:
    made: Any = graphnav.make_vec_env("corridor_ccw", 2, **OPTIONS, reward=lambda one: reward_of(one))
    made.reset(seed=3)
    pids = [one.pid for one in workers(made)]
    assert made.step(np.zeros((2, 2)))[1].tolist() == [0.1, 0.1]
    made.step(np.zeros((2, 2)))
    with pytest.raises(GraphnavError, match="^world 0: the reward function raised ValueError: too late$"):
        made.step(np.zeros((2, 2)))
    assert not any(map(is_alive, pids))
    with pytest.raises(UserError, match="the vector environment is closed"):
        made.step(np.zeros((2, 2)))


@pytest.mark.long
def test_a_killed_process_is_told_and_nothing_stays() -> None:
    made: Any = graphnav.make_vec_env("corridor_ccw", 2, **OPTIONS)
    pids = [one.pid for one in workers(made)]
    made.reset(seed=3)
    os.kill(pids[1], signal.SIGKILL)
    with pytest.raises(GraphnavError, match="^process 1 of world 1 was killed by signal 9$"):
        for _ in range(2):
            made.step(np.zeros((2, 2)))
    assert not any(map(is_alive, pids))
    made.close()


@pytest.mark.long
def test_processes_end_with_the_environment_and_with_the_program() -> None:
    made: Any = graphnav.make_vec_env("corridor_ccw", 1, **OPTIONS)
    (pid,) = (one.pid for one in workers(made))
    del made
    gc.collect()
    assert not is_alive(pid)
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert not is_alive(int(done.stdout))
    assert not done.stderr


@pytest.mark.parametrize("n", [0, -1, 1.5, True, "2"])
def test_the_number_of_worlds_is_checked(n: Any) -> None:
    with pytest.raises(UserError, match=r"^n must be an integer from 1 to 4096"):
        graphnav.make_vec_env("corridor_ccw", n)


def test_spaces_of_several_arrays_are_shared_too() -> None:
    made = graphnav.make_vec_env("pillars", 2, processes=1, observe=["robot.image", "robot.goal"], **OPTIONS)
    observation, _ = made.reset(seed=3)
    made.step(made.action_space.sample())
    made.close()
    assert {name: one.shape for name, one in observation.items()} == {
        "image": (2, 120, 160),
        "goal_bearing_rad": (2, 1),
        "goal_distance_m": (2, 1),
    }
    assert isinstance(made.observation_space, gymnasium.spaces.Dict)
