"""An episode publishes and leaves the same as a run with its commands."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import graphnav
from graphnav import Recording, UserError
from graphnav.core.cli import main

PLUGIN = Path(__file__).with_name("policies.py")
SEED, UNTIL_S = 5, 2.0


def messages(folder: Path) -> dict[str, list[bytes]]:
    """Return the bytes of every channel of a log."""
    found: dict[str, list[bytes]] = defaultdict(list)
    with Recording(folder / "run.lcmlog") as recording:
        for event in recording.events():
            found[event.channel].append(event.data)
    return found


def drive(env: Any, commands: Iterable[tuple[float, Any]]) -> None:
    """Step an episode with the commands of a log, each at its time."""
    _, info = env.reset(seed=SEED)
    for at_s, twist in commands:
        assert info["utime"] == round(at_s * 1e6)
        *_, terminated, truncated, info = env.step(np.array([twist.v_mps, twist.omega_radps]))
        if terminated or truncated:
            return


@pytest.mark.parametrize(
    ("graph", "stage", "observe"), [("corridor_ccw", "weave", None), ("pillars", "half", "plane.plane")]
)
@pytest.mark.long
def test_the_bytes_are_those_of_a_run_with_the_same_commands(
    graph: str, stage: str, observe: str | None, tmp_path: Path
) -> None:
    sets = {"control": f"policies.{stage}", "run.record": "all", "run.until_s": UNTIL_S}
    graphnav.run(graph, plugins=[PLUGIN], set=sets, seed=SEED, folder=tmp_path / "run", pictures=False)
    commands = list(graphnav.open_log(tmp_path / "run").messages("control.twist"))
    env = graphnav.make_env(
        graph,
        plugins=[PLUGIN],
        set={**sets},
        observe=observe,
        skip=False,
        record=tmp_path / "episodes",
    )
    drive(env, commands)
    env.close()
    run, episode = messages(tmp_path / "run"), messages(tmp_path / "episodes" / "0000")
    assert run.keys() == episode.keys()
    for channel in run.keys() - {"graphnav.about", "control.twist", "guard.twist", "guard.state"}:
        assert episode[channel] == run[channel], channel
    for channel in ("control.twist", "guard.state"):  # the run also acts in its last tick
        assert episode[channel] == run[channel][:-1]
    assert episode["guard.twist"][:-1] == run["guard.twist"][:-2]  # the last one takes the command back


def test_a_record_is_a_run_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    env = graphnav.make_env("corridor_ccw", record=tmp_path, time_limit_s=1.0)
    env.reset(seed=3)
    while not any(env.step(np.array([0.2, 0.3]))[2:4]):
        pass
    env.reset(seed=4)
    env.step(np.array([0.2, 0.3]))
    env.close()
    folder, stopped = tmp_path / "0000", tmp_path / "0001"
    assert main(["replay", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "no differences" in told
    assert "stepped: flow, planar, plane, guard, drive" in told
    assert main(["info", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "seed 3" in told
    assert "outcome timeout" in told
    assert "jump" not in told
    assert main(["info", str(stopped)]) == 0
    assert "outcome stopped" in capsys.readouterr().out
    assert main(["figure", str(folder)]) == 0
    assert (folder / "map.png").stat().st_size > 0
    again = graphnav.run(folder / "graph.yaml", until_s=0.2, pictures=False)
    assert "the agent of an episode is not part of its graph" in again.failure


def test_a_record_with_the_truth_says_that_its_agent_sees_it(tmp_path: Path) -> None:
    observe = ["robot.image", "robot.state.x_m"]
    env = graphnav.make_env("corridor_ccw", observe=observe, truth=True, act="guard", record=tmp_path, time_limit_s=0.3)
    observation, _ = env.reset(seed=3)
    assert set(observation) == {"image", "state_x_m"}
    env.close()
    graph = graphnav.load(tmp_path / "0000" / "graph.yaml")
    assert graph.node("guard").stage_class.role == "oracle"


def test_a_failed_episode_is_a_failed_run(tmp_path: Path) -> None:
    sets = {"control": "policies.half", "control.fails_at_s": 0.25}
    observe = ["robot.image", "control.twist"]
    env = graphnav.make_env(
        "corridor_ccw", act="guard", observe=observe, plugins=[PLUGIN], set=sets, record=tmp_path, time_limit_s=1.0
    )
    env.reset(seed=3)
    env.step(np.array([0.1, 0.0]))
    with pytest.raises(graphnav.GraphnavError, match="no way out"):
        env.step(np.array([0.1, 0.0]))
    summary = (tmp_path / "0000" / "summary.json").read_text()
    env.close()
    assert '"outcome": "failed"' in summary
    assert "no way out" in summary


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    env = graphnav.make_env("corridor_ccw", act="guard", record=tmp_path / "file")
    with pytest.raises(UserError, match="record: cannot make"):
        env.reset(seed=3)
    env.close()
