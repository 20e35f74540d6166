"""``graphnav check`` says what a graph is made of, or everything that is wrong with it."""

from pathlib import Path

import pytest

from graphnav.cli import main

TOYS = Path(__file__).parent.parent.parent / "errors" / "stages.py"
GRAPH = """\
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, in: {image: robot.image}}
  plane: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
channels: {robot.image: CAMERA}
"""


@pytest.fixture(autouse=True)
def _graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    Path("graph.yaml").write_text(GRAPH)


def test_a_sound_graph_is_shown_in_firing_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "graph", "--plugin", str(TOYS)]) == 0
    said = capsys.readouterr().out
    assert [said.index(use) for use in ("toy.robot", "toy.matcher", "toy.detector", "toy.wheels")] == sorted(
        said.index(use) for use in ("toy.robot", "toy.matcher", "toy.detector", "toy.wheels")
    )
    assert "wheels.twist (latest)" in said
    assert "robot.image: Image as CAMERA" in said
    assert said.splitlines()[-1] == "graph.yaml is fine: 1 source, 3 other stages, 5 channels"


LIVE = """\
inputs:
  camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}
  past.motion: {log: past.lcmlog, type: toy.odometer_t}
stages:
  flow: {use: toy.matcher, in: {image: camera.image}}
  plane: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  guard: {use: toy.guard, every_ms: 50, in: {command: wheels.twist, plane: plane.plane}}
outputs: {guard.twist: {channel: BASE_CMD, type: toy.wheels_t, motor: true}, plane.plane: {channel: PLANE}}
"""


def test_what_comes_in_and_leaves_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    Path("live.yaml").write_text(LIVE)
    Path("past.lcmlog").touch()
    assert main(["check", "live", "--plugin", str(TOYS)]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["camera", "input", "CAMERA:", "image_t", "camera.image:", "Image"] in rows
    assert ["past", "log", "past.lcmlog:", "past.motion:", "toy.odometer_t", "past.motion:", "Motion"] in rows
    assert ["motor", "output", "guard.twist", "BASE_CMD:", "toy.wheels_t"] in rows
    assert ["output", "plane.plane", "PLANE:", "plane_t"] in rows
    assert " ".join(rows[-2]) == (
        "it runs live: it listens to CAMERA, it plays past.lcmlog, it sends BASE_CMD (motor), PLANE"
    )
    assert " ".join(rows[-1]) == "live.yaml is fine: 2 inputs, 0 sources, 4 other stages, 6 channels, 2 outputs"


def test_a_swap_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "graph.yaml", "--plugin", str(TOYS), "--set", "plane=toy.guess"]) == 0
    assert "flow: pruned, no stage reads it any more" in capsys.readouterr().out


def test_what_a_parameter_names_is_looked_at(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "graph", "--plugin", str(TOYS), "--set", "robot.map=nowhere.yaml"]) == 2
    said = capsys.readouterr().err
    assert said == "--set robot.map=nowhere.yaml: toy.robot: there is no map nowhere.yaml\n  name a file\n"


def test_a_missing_plugin_is_a_users_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "graph", "--plugin", "none.py"]) == 2
    assert capsys.readouterr().err == "plugin none.py: there is no such file\n"


def test_a_huge_file_is_refused_unread(capsys: pytest.CaptureFixture[str]) -> None:
    with Path("huge.yaml").open("wb") as file:
        file.truncate(10**10)
    assert main(["check", "huge.yaml"]) == 2
    assert capsys.readouterr().err == (
        "huge.yaml: it has 10000000000 bytes, but a YAML file that graphnav reads has at most 262144\n"
        "  check that this is the file that you mean\n"
    )
