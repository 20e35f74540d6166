"""Networks in graphs: wired, swapped in, driven, replayed, compared, live."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest
from onnx import ModelProto, helper

import graphnav
from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.graph import load_graph
from graphnav.core.render import AnnouncedGraph
from graphnav.core.runner import about_of

from .networks import linear, means, network, recurrent

GRAPH = """\
run: {{until_s: 1, seed: 3}}
stages:
  robot: {{use: {robot}, in: {{command: policy.twist}}}}
  policy:
    use: policy.onnx
    with:
      file: network.onnx
      {params}
    in: {wires}
"""
ACTION = "outputs: {y: [twist.v_mps, twist.omega_radps]}"
WORLD = "world.pymunk, with: {map: maps/corridor_ccw.yaml, rate_hz: 5}"
TOYS = Path(__file__).parents[2] / "errors" / "stages.py"


def law() -> ModelProto:
    """Return the control law of a unicycle: v = 0.3 max(cos theta, 0), omega = 1.2 sin theta, T and R of [OI]."""
    nodes = [("Cos", "theta", "c"), ("Relu", "c", "ahead"), ("Sin", "theta", "s")]
    ends = [helper.make_node("Concat", ["ahead", "s"], ["both"], axis=1), ("Mul", "both limits", "y")]
    return network([*nodes, *ends], {"theta": (1, 1)}, {"y": (1, 2)}, {"limits": [[0.3, 1.2]]})


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder that is the working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(model: ModelProto, params: str, wires: str, robot: str = "toy.robot") -> str:
    """Write a graph of a robot and a network into the working folder; return its name."""
    Path("network.onnx").write_bytes(model.SerializeToString())
    Path("graph.yaml").write_text(GRAPH.format(params=params, wires=wires, robot=robot))
    return "graph.yaml"


def test_a_network_drives_through_the_corridor(here: Path) -> None:
    graph = written(
        law(), f"inputs: {{theta: steering.theta_rad}}\n      {ACTION}", "{steering: steer.steering}", WORLD
    )
    ways = "  steer: {use: steer.oracle, in: {map: robot.map, state: robot.state}}\n"
    (here / graph).write_text((here / graph).read_text() + ways)
    run = graphnav.run(graph, until_s=80, folder="drive", pictures=False)
    assert run.outcome == "goal"


def test_a_network_takes_the_place_of_a_stage(here: Path) -> None:
    (here / "law.onnx").write_bytes(law().SerializeToString())
    words = {
        "control": "policy.onnx",
        "control.file": "law.onnx",
        "control.inputs": {"theta": "steering.theta_rad"},
        "control.outputs": {"y": ["twist.v_mps", "twist.omega_radps"]},
    }
    run = graphnav.run("corridor_ccw", set=words, until_s=0.5, folder="drive", pictures=False)
    speeds = [twist.v_mps for _, twist in run.log.messages("control.twist")]
    assert len(speeds) > 2
    assert all(0.0 <= speed < 0.301 for speed in speeds)


def test_a_run_is_the_same_twice_loads_again_and_is_replayed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    graph = written(
        recurrent(),
        f"inputs: {{x: motion.forward_m}}\n      {ACTION}\n      state: {{h_out: h}}",
        "{motion: robot.motion}",
    )
    logs = []
    for folder, source in (("one", graph), ("two", graph), ("again", "one/graph.yaml")):
        plugin = ["--plugin", str(TOYS)] if source == graph else []
        assert main(["run", source, "-o", folder, "--no-tap", "--no-pictures", *plugin]) == 0
        logs.append((here / folder / "run.lcmlog").read_bytes())
    assert logs[0] == logs[1]
    assert len(logs[2]) > 1000
    assert main(["replay", "one", "--plugin", str(TOYS)]) == 0
    assert "no differences: " in capsys.readouterr().out


def test_a_nan_ends_the_run_in_one_line(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = network([("Sub", "x x", "z"), ("Div", "z z", "y")], {"x": (1, 2)}, {"y": (1, 2)})
    graph = written(model, f"inputs: {{x: [motion.left_m, motion.turn_rad]}}\n      {ACTION}", "{motion: robot.motion}")
    assert main(["run", graph, "-o", "out", "--no-tap", "--no-pictures", "--plugin", str(TOYS)]) == 1
    told = "stage 'policy' (policy.onnx) failed at 0.00 s: output 'twist' holds a NaN or an infinity in 'v_mps'"
    assert told in capsys.readouterr().err
    assert json.loads((here / "out" / "summary.json").read_text())["outcome"] == "failed"


def test_a_picture_of_another_size_ends_the_run_in_one_line(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wires, params = "{image: robot.image}", f"inputs: {{x: image.pixels}}\n      {ACTION}\n      history: {{x: 2}}"
    graph = written(means(2, 60, 80), params, wires)
    assert main(["run", graph, "-o", "out", "--no-tap", "--no-pictures", "--plugin", str(TOYS)]) == 1
    told = "the network's input 'x' takes (1, 2, 60, 80), but image.pixels is (1, 2, 12, 16)"
    assert f"stage 'policy' (policy.onnx) failed at 0.00 s: {told}\n" in capsys.readouterr().err


def test_a_message_of_another_package_goes_in_and_out(here: Path) -> None:
    (here / "mine.py").write_text(
        "import graphnav_lcm\n"
        "from graphnav import Message, Source, Stage, Twist, Latest, hookimpl\n"
        "class PolicyWish(Message, lcm=graphnav_lcm.goal_t):\n"
        "    bearing_rad: float\n"
        "    distance_m: float\n"
        "class Asks(Source):\n"
        "    '''Asks.'''\n"
        "    def step(self, command: Latest[PolicyWish]) -> PolicyWish:\n"
        "        return PolicyWish(0.5, (command.value.distance_m if command.value else 0.0) + 1.0)\n"
        "@hookimpl\n"
        "def graphnav_stages(): return [Asks]\n"
    )
    graph = written(
        linear(1, [[0, 2]], [0, 0]),
        "inputs: {x: policy_wish.distance_m}\n      outputs: {y: [policy_wish.bearing_rad, policy_wish.distance_m]}",
        "{policy_wish: robot}",
        "mine.asks",
    )
    text = Path(graph).read_text().replace("policy.twist", "policy.policy_wish")
    stages = text.index("  robot:"), text.index("  policy:")
    Path(graph).write_text(text[: stages[0]] + text[stages[1] :] + text[stages[0] : stages[1]])  # the writer last
    run = graphnav.run(graph, plugins=["mine.py"], folder="out", pictures=False)
    values = [message.distance_m for _, message in run.log.messages("policy.policy_wish")]
    assert values[:3] == [2.0, 6.0, 14.0]


def test_what_extends_a_graph_swaps_a_network_in(here: Path) -> None:
    (here / "law.onnx").write_bytes(law().SerializeToString())
    Path("mine.yaml").write_text(
        "extends: corridor_ccw\n"
        "stages:\n"
        "  control:\n"
        "    use: policy.onnx\n"
        "    with:\n"
        "      file: law.onnx\n"
        "      inputs: {theta: steering.theta_rad}\n"
        "      outputs: {y: [twist.v_mps, twist.omega_radps]}\n"
    )
    graph = load_graph("mine.yaml", Catalog())
    wires = {i.port.name: i.channel and i.channel.ref for i in graph.node("control").inputs}
    assert wires == {"steering": "steer.steering"}
    assert next(i.channel and i.channel.ref for i in graph.node("guard").inputs) == "control.twist"


def test_a_study_compares_networks(here: Path) -> None:
    slow, fast = (linear(1, [[0, 0]], [speed_mps, 0]) for speed_mps in (0.1, 0.3))
    graph = written(slow, f"inputs: {{x: motion.left_m}}\n      {ACTION}", "{motion: robot.motion}", WORLD)
    (here / "fast.onnx").write_bytes(fast.SerializeToString())
    score = "  drive: {use: score.navigation, in: {state: robot.state, map: robot.map}}\n"
    (here / graph).write_text((here / graph).read_text() + score)
    files = ["network.onnx", "fast.onnx"]
    study = graphnav.ablate(graph, vary={"policy.file": files}, seeds=[1000], jobs=1, folder="study", gallery=0)
    assert len(study.runs) == 2
    assert study.runs["drive.mean_clearance_m"].nunique() == 2
    file = here / "fast.onnx"
    file.write_bytes(slow.SerializeToString())
    with pytest.raises(graphnav.UserError, match=r"were made with another file fast\.onnx: [0-9a-f]+, now [0-9a-f]+"):
        graphnav.ablate(graph, vary={"policy.file": files}, seeds=[1000], jobs=1, folder="study", gallery=0)


def test_a_run_tells_which_network_drove(here: Path) -> None:
    graph = written(
        linear(1, [[0, 0]], [0, 0]), f"inputs: {{x: motion.left_m}}\n      {ACTION}", "{motion: robot.motion}"
    )
    graphnav.run(graph, folder="run", pictures=False, plugins=[TOYS])
    digest = hashlib.sha256(hashlib.sha256((here / "network.onnx").read_bytes()).digest()).hexdigest()
    versions = json.loads((here / "run" / "summary.json").read_text())["versions"]
    assert versions["file network.onnx"] == digest[:12]


def test_viewers_see_the_ports_of_a_running_network(here: Path) -> None:
    catalog = Catalog().add_files([TOYS])
    params = f"inputs: {{x: motion.left_m}}\n      {ACTION}"
    graph = load_graph(written(linear(1, [[0, 0]], [0, 0]), params, "{motion: robot.motion}"), catalog)
    policy = next(box for box in AnnouncedGraph.read(about_of(graph), catalog).boxes if box.key == "policy")
    assert [(port.name, port.channel and port.channel.ref) for port in policy.inputs] == [("motion", "robot.motion")]
    assert [port.name for port in policy.outputs] == ["twist"]


@pytest.mark.parametrize("form", ["table", "--json"])
def test_the_list_of_stages_says_that_parameters_give_the_ports(form: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", "policy.onnx", *([form] if form != "table" else [])]) == 0
    printed = capsys.readouterr().out
    if form == "table":
        assert "as inputs, outputs and latest say" in " ".join(printed.split())
    else:
        assert json.loads(printed)["ports_from"] == ["inputs", "outputs", "latest"]
