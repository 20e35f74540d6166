"""``graphnav check`` says what a graph is made of, or everything that is wrong with it."""

from pathlib import Path

import pytest

from graphnav.core.cli import main

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
    assert capsys.readouterr().err == "plugin none.py: file not found\n"


def test_a_huge_file_is_refused_unread(capsys: pytest.CaptureFixture[str]) -> None:
    with Path("huge.yaml").open("wb") as file:
        file.truncate(10**10)
    assert main(["check", "huge.yaml"]) == 2
    assert capsys.readouterr().err == (
        "huge.yaml: it has 10000000000 bytes, but a YAML file that graphnav reads has at most 262144\n"
        "  check that this is the file that you mean\n"
    )


def test_several_graphs_are_checked_together(capsys: pytest.CaptureFixture[str]) -> None:
    Path("one.yaml").write_text(GRAPH.replace("toy.matcher", "toy.macher"))
    Path("two.yaml").write_text("stages: {}\n")
    assert main(["check", "two", "graph", "one", "--plugin", str(TOYS)]) == 2
    out, err = capsys.readouterr()
    assert out == "graph.yaml is fine: 1 source, 3 other stages, 5 channels\n"
    assert [line.partition(":")[0] for line in err.splitlines() if not line.startswith("  ")] == [
        "one.yaml",
        "two.yaml",
        "2 errors",
    ]


def test_several_graphs_are_not_resolved(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "graph", "graph", "--resolved", "--plugin", str(TOYS)]) == 2
    assert capsys.readouterr().err == "--resolved: --resolved prints one graph\n  name one\n"


BROKEN = """\
stages:
  robot: {use: world.pymunk, with: {map: no_map.yaml, rat_hz: 3}}
  steer: {use: steer.frontier}
"""


def test_a_missing_map_is_reported_beside_the_other_errors(capsys: pytest.CaptureFixture[str]) -> None:
    Path("broken.yaml").write_text(BROKEN)
    assert main(["check", "broken"]) == 2
    folder = Path.cwd()
    assert capsys.readouterr().err == (
        f"broken.yaml:2:42: world.pymunk: 'map' is not a file: {folder}/no_map.yaml\n"
        "  give the path of a map's YAML file\n"
        "broken.yaml:2:55: world.pymunk has no parameter 'rat_hz'\n"
        "  did you mean 'rate_hz'?\n"
        "broken.yaml:3:3: input 'map' of stage 'steer' (steer.frontier) is not connected\n"
        "  write in: {map: stage.port}; no stage here writes LocalMap: "
        "add mapping.lidar or mapping.local, as lidar: {use: mapping.lidar}\n"
        "3 errors\n"
    )


def test_swaps_of_the_graphs_own_files_are_told_with_v_alone(capsys: pytest.CaptureFixture[str]) -> None:
    Path("over.yaml").write_text("extends: graph.yaml\nstages: {plane: {use: toy.guess}}\n")
    said = "plane: toy.detector swapped for toy.guess"
    assert main(["check", "over", "--plugin", str(TOYS)]) == 0
    assert said not in capsys.readouterr().out
    assert main(["check", "over", "-v", "--plugin", str(TOYS)]) == 0
    assert said in capsys.readouterr().out
    assert main(["check", "over", "--resolved", "--plugin", str(TOYS)]) == 0
    assert f"# {said}" in capsys.readouterr().out


def test_what_a_plugin_raises_is_shown_with_v(capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.py").write_text("import no_such_module\n")
    assert main(["check", "graph", "--plugin", "mine.py"]) == 2
    said = "plugin mine.py:1: ModuleNotFoundError: No module named 'no_such_module'\n"
    assert capsys.readouterr().err == f"{said}  -v shows the traceback\n"
    assert main(["check", "graph", "--plugin", "mine.py", "-v"]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"{said}Traceback (most recent call last):\n")
    assert err.endswith("ModuleNotFoundError: No module named 'no_such_module'\n")
