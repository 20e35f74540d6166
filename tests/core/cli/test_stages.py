"""``graphnav stages`` tells everything that a graph may say of a stage."""

import json
import shutil
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.graph import graph_of
from graphnav.core.stage import params_of, ports_of

TOYS = Path(__file__).parent.parent.parent / "errors" / "stages.py"


@pytest.fixture(autouse=True)
def _wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")


@pytest.mark.parametrize("use", ["plane.ica", "world.pymunk", "flow.lucas_kanade"])
def test_one_stage_is_told_with_all_ports_and_parameters(use: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", use]) == 0
    said = " ".join(capsys.readouterr().out.split())
    cls = Catalog().stage(use)
    for port in (*ports_of(cls).inputs, *ports_of(cls).outputs):
        assert f"{port.name} {port.message.__name__}" in said
    for param in params_of(cls).values():
        assert param.name in said
        assert param.bounds_text in said
        assert param.doc.split()[0] in said


def test_a_paragraph_of_help_flows(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "1000")
    assert main(["stages", "plane.ica"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("FastICA" in line and line.endswith("near 0.") for line in map(str.rstrip, lines))
    assert lines[lines.index("References") + 1] == "----------"


def test_the_snippet_is_a_graph_once_it_is_wired(
    toys: Catalog, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["stages", "toy.detector", "--plugin", str(TOYS)]) == 0
    snippet = capsys.readouterr().out.partition("In a graph:\n")[2]
    others = (
        "  robot: {use: toy.robot, in: {command: wheels.twist}}\n"
        "  flow: {use: toy.matcher, in: {image: robot.image}}\n"
        "  wheels: {use: toy.wheels, in: {plane: toy.plane}}\n"
    )
    text = snippet.replace("STAGE.PORT", "flow.flow") + others
    graph = graph_of(text.encode(), tmp_path / "graph.yaml", toys)
    assert graph.node("toy").params == {n: p.default for n, p in params_of(toys.stage("toy.detector")).items()}


def test_a_path_is_never_wrapped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plugin = Path(shutil.copy(TOYS, tmp_path / "toys_with_a_name_as_long_as_it_may_be.py"))
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["stages", "toy.detector", "--plugin", str(plugin)]) == 0
    assert capsys.readouterr().out.splitlines()[0] == f"toy.detector, a stage of {plugin}"


def test_json_holds_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", "plane.affine", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["name"] == "plane.affine"
    assert {"name": "flow", "type": "Flow", "latest": False, "since": False, "open": False} in told["inputs"]
    assert [p["name"] for p in told["parameters"]] == list(params_of(Catalog().stage("plane.affine")))
    assert all(param["doc"] for param in told["parameters"])


def test_all_stages_of_all_families_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages"]) == 0
    said = capsys.readouterr().out
    catalog = Catalog()
    assert all(f"{f}.{name} " in said for f in catalog.families() for name in catalog.names(f))
    assert main(["stages", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == sum(len(catalog.names(f)) for f in catalog.families())


def test_a_family_is_listed_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", "flow"]) == 0
    said = capsys.readouterr().out
    assert "flow.dis" in said
    assert "plane." not in said


def test_an_unknown_name_is_told_with_what_is_near(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", "plane.icca"]) == 2
    assert capsys.readouterr().err == "family 'plane' has no stage 'icca'\n  did you mean 'ica'?\n"


@pytest.mark.parametrize("name", ["LocalMap", "localmap", "floor_map_t"])
def test_a_message_lists_what_writes_and_reads_it(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", name, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["message"] == "LocalMap"
    wanted = [{"stage": f"mapping.{name}", "port": "local_map", "reading": ""} for name in ("lidar", "local")]
    assert said["writers"] == wanted
    assert {"stage": "steer.frontier", "port": "map", "reading": ""} in said["readers"]
    assert {"stage": "control.nonholonomic", "port": "map", "reading": "latest"} in said["readers"]
    assert main(["stages", name]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert any(words[:4] == ["written", "by", "mapping.local", "local_map"] for words in lines)
    assert any(words[:4] == ["read", "by", "steer.frontier", "map"] for words in lines)


def test_a_name_that_is_neither_stage_nor_message_gets_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stages", "localmpa"]) == 2
    assert capsys.readouterr().err == ("'localmpa' is not a stage, a family or a message\n  did you mean 'LocalMap'?\n")
