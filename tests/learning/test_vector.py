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

import numpy as np
import pytest
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv

import graphnav
from graphnav import GraphnavError, UserError
from graphnav.learning.reward import Transition

OPTIONS: dict[str, Any] = {"act": "guard", "time_limit_s": 0.5}
N, SEEDS = 2, [3, 4]
REFUSED = [
    (np.full((N, 2), np.nan), "the array of actions holds a NaN or an infinity"),
    (np.zeros(2), "the array of actions has the shape"),
    (["a"] * N, "the array of actions is of"),
]
SCRIPT = """
import graphnav
vector = graphnav.make_vec_env("approach", 1, act="guard", processes=1)
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
    observation, info = vector.reset(seed=SEEDS)
    yield observation, info["seed"]
    for _ in range(8):
        *found, info = vector.step(rng.uniform(-0.3, 0.3, (N, 2)).astype(np.float32))
        yield (*found, info["utime"], info["seed"])


@pytest.mark.long
def test_worlds_in_processes_are_those_of_gymnasiums_vectors() -> None:
    factory = functools.partial(graphnav.make_env, "approach", **OPTIONS)
    ours = graphnav.make_vec_env("approach", N, **OPTIONS)
    vectors = [ours, SyncVectorEnv([factory] * N), AsyncVectorEnv([factory] * N)]
    assert ours.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert ours.observation_space == vectors[1].observation_space
    assert ours.action_space == vectors[1].action_space
    given = [list(episodes(one)) for one in vectors]
    for one in vectors:
        one.close()
    for mine, *theirs in zip(*given, strict=True):
        for other in theirs:
            for array, its in zip(mine, other, strict=True):
                if mine[-1].tolist() == SEEDS:  # those of later episodes are drawn by each world
                    assert (array == its).all()


@pytest.mark.long
def test_worlds_begin_again_and_refuse_what_does_not_fit() -> None:
    options = {**OPTIONS, "observe": ["robot.image", "robot.motion.forward_m"]}
    made: Any = graphnav.make_vec_env("approach", N, processes=1, **options)
    assert made.reset(seed=7)[1]["seed"].tolist() == [7, 8]
    observation, info = made.reset(seed=SEEDS)
    assert info["seed"].tolist() == SEEDS
    assert {name: one.shape for name, one in observation.items()} == {
        "image": (N, 120, 160),
        "motion_forward_m": (N, 1),
    }
    with pytest.raises(UserError, match=r"reset: the seeds are \[1\]"):
        made.reset(seed=[1])
    for actions, told in REFUSED:
        with pytest.raises(UserError, match=told):
            made.step(actions)
    for _ in range(4):
        *_, truncated, info = made.step(made.action_space.sample())
    assert truncated.all()
    assert info["utime"].tolist() == [500_000] * N
    assert info["outcome"].tolist() == ["timeout"] * N
    _, reward, _, truncated, info = made.step(made.action_space.sample())
    assert reward.tolist() == [0.0] * N
    assert not truncated.any()
    assert info["utime"].tolist() == [100_000] * N
    (pid,) = (one.pid for one in workers(made))
    del made
    gc.collect()
    assert not is_alive(pid)


def reward_of(one: Transition) -> float:
    """Return the time; 10 fails."""
    if one.utime > 250_000:
        raise ValueError("too late")
    return one.utime * 1e-6


@pytest.mark.long
def test_a_world_that_fails_ends_all() -> None:
    made: Any = graphnav.make_vec_env("approach", 1, **OPTIONS, reward=reward_of)
    made.reset(seed=3)
    pids = [one.pid for one in workers(made)]
    assert made.step(np.zeros((1, 2)))[1].tolist() == pytest.approx([0.1])
    made.step(np.zeros((1, 2)))
    with pytest.raises(GraphnavError, match=r"^world 0: the reward function raised ValueError: too late$"):
        made.step(np.zeros((1, 2)))
    assert not any(map(is_alive, pids))
    with pytest.raises(UserError, match="the vector environment is closed"):
        made.step(np.zeros((1, 2)))


@pytest.mark.long
def test_a_killed_process_is_told_and_nothing_stays() -> None:
    made: Any = graphnav.make_vec_env("approach", 1, **OPTIONS)
    pids = [one.pid for one in workers(made)]
    made.reset(seed=3)
    os.kill(pids[0], signal.SIGKILL)
    workers(made)[0].wait()
    with pytest.raises(GraphnavError, match=r"^process 0 of world 0 was killed by signal 9$"):
        made.step(np.zeros((1, 2)))
    assert not any(map(is_alive, pids))
    made.close()


@pytest.mark.long
def test_processes_end_with_the_program() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert not is_alive(int(done.stdout))
    assert not done.stderr


@pytest.mark.parametrize("n", [0, -1, 1.5, True, "2"])
def test_the_number_of_worlds_is_checked(n: Any) -> None:
    with pytest.raises(UserError, match=r"^n must be an integer from 1 to 4096"):
        graphnav.make_vec_env("approach", n)
