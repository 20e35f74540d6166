"""Episodes of a graph as Gymnasium knows them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import graphnav
from graphnav import GraphnavError, UserError
from graphnav.core.graph import shipped_graphs
from graphnav.gym import OPEN, environments
from graphnav.learning.reward import Transition

PLUGIN = Path(__file__).with_name("policies.py")
ON = np.array([0.2, 0.1], np.float32)


def steps(env: Any, seed: int | None, n: int) -> list[Any]:
    """Return what an episode gives."""
    found = [env.reset(seed=seed)]
    rng = np.random.default_rng(0)
    while len(found) <= n and not any(found[-1][2:4]):
        found.append(env.step(rng.uniform(-0.3, 0.3, 2)))
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    "graph",
    [
        "corridor_ccw",
        "barn_navigate",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("pillars", "navigate", "approach")),
    ],
)
def test_gymnasium_has_nothing_against_it(graph: str) -> None:
    env = gymnasium.make(
        f"graphnav/{graph}-v0", render_mode="rgb_array", time_limit_s=0.5, normalized=True, act="guard"
    )
    is_first = graph == "corridor_ccw"  # the others are not made again for their pictures and for closing
    check_env(env.unwrapped, skip_render_check=not is_first, skip_close_check=not is_first)
    env.close()


def test_every_closed_loop_that_ships_is_registered() -> None:
    assert set(environments().values()) == set(shipped_graphs()) - OPEN
    assert all(name in gymnasium.registry for name in environments())
    assert gymnasium.spec("graphnav/navigate.maze-v0").kwargs == {"graph": "navigate/maze"}


def test_what_is_not_registered_is_not_a_closed_loop() -> None:
    for name in ("robot_live", "teach_live"):
        with pytest.raises(UserError, match="has live inputs, but a learner needs a simulated world"):
            graphnav.make_env(name)


def test_the_spaces_are_those_of_image_and_robot(fast: Any) -> None:
    assert fast.observation_space == gymnasium.spaces.Box(0, 255, (120, 160), np.uint8)
    assert fast.action_space.low.tolist() == [-0.5, -2.0]
    assert fast.action_space.high.tolist() == [0.5, 2.0]
    assert fast.metadata["render_fps"] == 10


def test_the_same_seed_is_the_same_episode(fast: Any) -> None:
    first, again, other = (steps(fast, seed, 3) for seed in (5, 5, 6))
    for one, same in zip(first, again, strict=True):
        assert (one[0] == same[0]).all()
        assert one[1:] == same[1:]
    assert (first[0][0] != other[0][0]).any()


def test_without_a_seed_gymnasiums_own_numbers_draw_the_next_world(fast: Any) -> None:
    fast.reset(seed=5)
    drawn = [fast.reset()[1]["seed"] for _ in range(2)]
    fast.reset(seed=5)
    assert [fast.reset()[1]["seed"] for _ in range(2)] == drawn
    assert drawn[0] != drawn[1]


def test_the_time_limit_truncates(fast: Any) -> None:
    last = steps(fast, 3, 99)[-1]
    assert last[2:4] == (False, True)
    assert (last[4]["outcome"], last[4]["utime"]) == ("timeout", 1_000_000)
    assert last[4]["metrics"]["drive.duration_s"] == pytest.approx(1.0)
    with pytest.raises(UserError, match="step: the episode has ended"):
        fast.step(ON)


def test_a_contact_terminates_and_counts() -> None:
    env = graphnav.make_env("approach", act="guard")
    env.reset(seed=7)
    total, terminated, truncated = 0.0, False, False
    while not (terminated or truncated):
        _, reward, terminated, truncated, info = env.step(np.array([0.5, 0.0]))
        total += float(reward)
    env.close()
    assert (terminated, truncated, info["outcome"]) == (True, False, "contact")
    assert total < -5


def test_the_scene_is_drawn(fast: Any) -> None:
    before = fast.render()
    for _ in range(5):
        fast.step(np.array([0.5, 0.0]))
    after = fast.render()
    assert before.dtype == np.uint8
    assert before.shape[2] == 3
    assert (before != after).any()


def test_progress_is_the_way_to_the_goal_that_is_gone() -> None:
    asked: list[Transition] = []

    def noted(one: Transition) -> float:
        asked.append(one)
        return 0.0

    env = graphnav.make_env("pillars", act="guard", reward=noted, time_limit_s=1)
    steps(env, 3, 99)
    env.close()
    driven_m = asked[-1].metrics["drive.path_length_m"]
    assert 0.0 < abs(sum(one.progress_m for one in asked)) < 1.1 * driven_m
    assert [one.utime for one in asked] == list(range(100_000, 1_000_001, 100_000))


def test_a_reward_counts_changes_of_metrics() -> None:
    env = graphnav.make_env("pillars", act="guard", reward={"drive.path_length_m": 2.0, "step": -1}, time_limit_s=1)
    given = steps(env, 3, 99)[1:]
    env.close()
    driven_m = given[-1][4]["metrics"]["drive.path_length_m"]
    assert sum(one[1] for one in given) == pytest.approx(2.0 * driven_m - len(given))


def test_several_channels_are_arrays_by_name() -> None:
    env = graphnav.make_env(
        "pillars", observe=["robot.image", "robot.goal", "guard.state.may_move"], act="steer", time_limit_s=1
    )
    observation, _ = env.reset(seed=3)
    assert {name: one.shape for name, one in observation.items()} == {
        "image": (120, 160),
        "goal_bearing_rad": (1,),
        "goal_distance_m": (1,),
        "state_may_move": (1,),
    }
    assert observation in env.observation_space
    action = env.action_space.sample()
    assert set(action) == {"repulsive", "guiding", "control", "theta_rad", "eigenvalues"}
    assert env.step(action)[0] in env.observation_space
    env.close()


def test_a_detector_can_be_the_agent() -> None:
    env = graphnav.make_env("corridor_ccw", observe="flow.flow", act="plane", time_limit_s=0.5)
    observation, info = env.reset(seed=3)
    assert info["utime"] == 100_000  # the first flow
    assert set(observation) == {"flow_uv_px", "flow_valid"}
    while not any((result := env.step(env.action_space.sample()))[2:4]):
        pass
    assert result[4]["metrics"]["drive.path_length_m"] >= 0.0
    env.close()


def test_what_nothing_needs_does_not_step() -> None:
    def stages(**options: Any) -> list[str]:
        env: Any = graphnav.make_env("corridor_ccw", **options)
        env.close()
        return [node.name for node in env.graph.nodes]

    assert stages(act="guard") == ["robot", "guard", "drive"]
    assert stages() == ["robot", "flow", "planar", "plane", "control", "guard", "drive"]
    assert len(stages(skip=False)) == 11


def test_an_error_of_a_stage_ends_the_episode() -> None:
    env = graphnav.make_env(
        "corridor_ccw",
        act="guard",
        observe=["robot.image", "control.twist"],
        plugins=[PLUGIN],
        set={"control": "policies.half", "control.fails_at_s": 0.35},
    )
    env.reset(seed=3)
    for _ in range(2):
        env.step(ON)
    told = r"^stage 'control' \(policies\.half\) failed at 0\.40 s: no way out\n  ValueError at policies"
    with pytest.raises(GraphnavError, match=told):
        env.step(ON)
    with pytest.raises(UserError, match="the episode has ended"):
        env.step(ON)
    env.reset(seed=3)
    env.close()


@pytest.mark.parametrize(
    ("action", "told"),
    [
        ([np.nan, 0.0], "the action holds a NaN or an infinity"),
        ([0.1], "the action has the shape (1,)"),
        (["fast", "left"], "the action is of <U4"),
        (None, "the action is of NoneType"),
        ([[0.1], [0.2, 0.3]], "the action is not an array"),
    ],
)
def test_an_action_of_another_form_is_refused(fast: Any, action: Any, told: str) -> None:
    with pytest.raises(UserError) as error:
        fast.step(action)
    assert str(error.value).startswith(told)
    fast.step(ON)


@pytest.mark.parametrize("seed", [-1, 2**32, 1.5, "7", True])
def test_a_seed_is_that_of_a_run(fast: Any, seed: Any) -> None:
    with pytest.raises(UserError, match="reset: the seed is"):
        fast.reset(seed=seed)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"observe": "robot.imag"}, "observe: corridor_ccw has no channel 'robot.imag'"),
        ({"observe": "robot.state"}, "observe: 'robot.state' is true data, which no robot has"),
        ({"observe": "robot"}, "observe: 'robot' publishes robot.image, robot.motion"),
        ({"observe": "guard.twist"}, "observe: all of guard.twist follows from the action"),
        ({"observe": "control.twist"}, "observe: the agent itself writes 'control.twist'"),
        ({"observe": []}, "observe names no channel"),
        ({"observe": "robot.goal.bearing"}, "observe: Goal of 'robot.goal' has no number 'bearing'"),
        ({"act": "sense"}, "act: corridor_ccw has no channel 'sense'"),
        ({"act": "robot.image"}, "act: 'robot' is a source, which no policy can replace"),
        ({"reward": {"drive.pth": 1.0}}, "reward: corridor_ccw has no term 'drive.pth'"),
        ({"reward": {"goal": "much"}}, "reward: the weight of 'goal' is 'much'"),
        ({"reward": 3}, "reward must be a mapping or a function, not int"),
        ({"time_limit_s": 0}, "time_limit_s is 0, but must be above 0"),
        ({"render_mode": "human"}, 'render_mode must be "rgb_array" or None'),
        ({"truth": 1}, "truth must be True or False"),
        ({"act": "plane", "observe": "steer.steering"}, "observe: all of steer.steering follows"),
    ],
)
def test_what_a_graph_does_not_have_is_told(options: dict[str, Any], told: str) -> None:
    with pytest.raises(UserError) as error:
        graphnav.make_env("corridor_ccw", **options)
    assert str(error.value).startswith(told)
