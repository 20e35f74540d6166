"""The network that ships: its file, its drive, and the drives that teach one."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import onnx
import pytest
from policy_training.drives import FRAMES, Drive, file_of, graph_of, make, policy_stage, seed_of, tuning_barn_worlds
from train_policy import ROUNDS, drives_of, main

import graphnav
from graphnav import Recording, Twist
from graphnav.core.graph.find import shipped_folder

SHIPPED = shipped_folder() / "models" / "policy_160x120.onnx"
MAX_BYTES = 2_000_000


def test_it_is_small_and_says_where_it_comes_from() -> None:
    model = onnx.load(SHIPPED)
    onnx.checker.check_model(model)
    about = {entry.key: entry.value for entry in model.metadata_props}
    assert SHIPPED.stat().st_size <= MAX_BYTES
    assert {"made_by", "drives", "seeds", "barn_worlds"} <= about.keys()
    assert model.opset_import[0].version <= 17


@pytest.mark.parametrize("world", ["tight", "doors", "barn"])
def test_it_drives(world: str) -> None:
    run = graphnav.run(f"learned/{world}", seed=1, until_s=1, pictures=False, check=True)
    assert run.outcome == "timeout"
    with Recording(run.folder / "run.lcmlog") as log:
        speeds = [message.v_mps for _, _, message in log.messages("guard.twist") if isinstance(message, Twist)]
    assert max(speeds) > 0.1


def test_no_drive_that_teaches_is_one_that_judges() -> None:
    planned = [drive for one in ROUNDS for drive in drives_of(one, None, None, 60.0)]
    barn = {drive.seed % 300 for drive in planned if drive.world == "barn"}
    assert max(drive.seed for drive in planned) < 900
    assert len({(drive.world, drive.seed) for drive in planned}) == len(planned)
    assert all(world % 3 and world % 12 not in (1, 5) for world in barn)
    assert barn <= {*tuning_barn_worlds()}


@pytest.mark.parametrize("world", ["tight", "doors", "barn"])
def test_a_drive_becomes_pictures_and_what_the_planner_would_do(world: str, tmp_path: Path) -> None:
    drive = Drive(world, seed_of(world, 0), SHIPPED, policy_ratio=0.5, chance_ratio=0.2, until_s=2.0)
    assert make(drive, tmp_path) in {"timeout", "contact", "goal"}
    assert make(drive, tmp_path) == "there already"
    with np.load(file_of(drive, tmp_path)) as made:
        n = len(made["directions"])
        assert n > FRAMES
        assert made["pictures"].shape == (n, 60, 80)
        assert made["pictures"].dtype == np.uint8
        assert (made["goals"][:, 1] > 0).all() == (world != "tight")
        assert np.abs(made["directions"]).max() <= np.pi


@pytest.mark.parametrize("world", ["tight", "doors", "speed", "barn"])
def test_a_network_is_taught_with_the_inputs_that_the_shipped_graph_gives_it(world: str) -> None:
    shipped = next(node for node in graphnav.load(f"learned/{world}").nodes if node.name == "policy")
    taught = policy_stage(SHIPPED, world)
    assert taught["use"] == shipped.use
    assert Path(taught["with"]["file"]) == shipped.settings["file"].value
    for name in ("inputs", "history", "outputs"):
        assert taught["with"][name] == shipped.settings[name].value
    wires = {one.port.name: one.channel.ref for one in shipped.inputs if one.channel is not None}
    assert taught["in"] == wires


def test_the_planner_drives_alone_before_there_is_a_network() -> None:
    graph = graph_of(Drive("corners", 5, None, 0.0, 0.3))
    assert "policy" not in graph["stages"]
    assert graph["stages"]["mix"]["in"] == {"teacher": "control.twist", "state": "robot.state"}


@pytest.mark.skipif(importlib.util.find_spec("torch") is not None, reason="torch is installed")
def test_without_torch_it_says_what_to_install(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path / "drives"), "-o", str(tmp_path / "network.onnx")]) == 2
    said = "tools/train_policy.py needs torch\n  pip install torch==2.13.0 onnx onnxruntime\n"
    assert capsys.readouterr().err == said
    assert not (tmp_path / "drives").exists()


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")
def test_a_tiny_budget_teaches_a_network_that_drives(tmp_path: Path) -> None:
    network = tmp_path / "network.onnx"
    assert main([str(tmp_path / "drives"), "-o", str(network), "--drives", "1", "--until", "2"]) == 0
    changed = {"policy.file": str(network)}
    assert (
        graphnav.run("learned/doors", set=changed, seed=1, until_s=1, pictures=False, check=True).outcome == "timeout"
    )
