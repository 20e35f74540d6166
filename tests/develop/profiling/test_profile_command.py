"""``graphnav profile``: what it prints, its exit status, and what it refuses."""

from __future__ import annotations

import importlib.util
import json
import shutil
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from graphnav.core.cli import main
from graphnav.core.trust import Request

STAGES = Path(__file__).parents[2] / "core" / "api" / "door_stages.py"
GRAPH = """\
plugins: [door_stages.py]
run: {until_s: 9.9, seed: 3}
stages:
  sensor: {use: door.sensor}
  steer: {use: door.steerer, in: {flow: sensor.flow}}
"""


@pytest.fixture
def graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the file of a graph of a hundred ticks, in the working folder."""
    monkeypatch.chdir(tmp_path)
    Path("toy.yaml").write_text(GRAPH)
    shutil.copy(STAGES, tmp_path)
    Request(tmp_path, ()).remember()
    return "toy.yaml"


def test_the_tables_and_nothing_else(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", graph]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("toy: 69 timed ticks of 100 (20 to warm up, 11 without instruments), seed 3; threads: blas ")
    assert out.splitlines()[0].endswith("; wall time")
    for word in ("door.steerer", "sensor.flow", "the ideal: only the steps", "100.0%", "clock readings a tick"):
        assert word in out
    assert sorted(path.name for path in Path().iterdir()) == ["door_stages.py", "toy.yaml"]


def test_the_run_is_that_of_run(graph: str) -> None:
    assert main(["run", graph, "-o", "plain", "--no-tap", "--no-pictures"]) == 0
    assert main(["profile", graph, "-o", "profiled", "--flame", "flame.svg"]) == 0
    assert Path("profiled/run.lcmlog").read_bytes() == Path("plain/run.lcmlog").read_bytes()


def test_json_is_the_profile(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", graph, "--json", "--seed", "5", "--set", "sensor.noise_px=1", "--clock", "cpu"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["graph"], found["seed"], found["outcome"], found["failure"]) == ("toy", 5, "timeout", "")
    assert found["clock"] == "cpu"
    assert found["ticks"] == {"bare": 11, "timed": 69, "warm_up": 20}
    assert sum(found["parts"].values()) == pytest.approx(found["tick_ms"])
    assert found["parts"]["step"] == found["ideal_ms"] == pytest.approx(sum(one["ms"] for one in found["stages"]))
    assert [one["name"] for one in found["stages"]] == ["sensor", "steer"]
    assert found["threads"].keys() >= {"blas"}


def test_the_slowest_first(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", graph, "--sort"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if " door." in line]
    assert len(rows) == 2
    assert [float(row[3]) for row in rows] == sorted((float(row[3]) for row in rows), reverse=True)


def test_the_flame_graph_is_written(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pyinstrument")
    assert main(["profile", graph, "--flame", "flame.svg"]) == 0
    out, err = capsys.readouterr()
    assert err == "wrote flame.svg\n"
    assert "for the functions inside of the steps" in out
    assert ET.parse("flame.svg").getroot().tag == "{http://www.w3.org/2000/svg}svg"


def test_without_pyinstrument_the_flame_graph_ends_at_the_steps(
    graph: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pyinstrument" else found(name))
    assert main(["profile", graph, "--flame", "flame.svg"]) == 0
    assert capsys.readouterr().err == (
        "the functions inside of the steps cannot be sampled: pyinstrument is not installed\n"
        "  install it: pip install 'pyinstrument>=5.0'\n"
        "wrote flame.svg\n"
    )
    assert ">step<" in Path("flame.svg").read_text()


RAISED = "  ValueError at door_stages.py:57 in _come_to_grief\n  -v shows the traceback\n"


def test_a_run_that_fails_has_the_times_up_to_there(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", graph, "--set", "sensor.grief=raise", "--set", "sensor.grief_tick=80"]) == 1
    out, err = capsys.readouterr()
    assert "timed ticks of 79 (" in out
    assert err == "stage 'sensor' (door.sensor) failed at 7.90 s: worn <b>out</b>\n" + RAISED


def test_a_run_that_is_interrupted_has_the_times_up_to_there(graph: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["profile", graph, "--set", "sensor.grief=interrupt", "--set", "sensor.grief_tick=80"]) == 130
    out, err = capsys.readouterr()
    assert "timed ticks of 80 (" in out
    assert err == "stopped; these are the times up to there\n"


NOTHING = "nothing was measured: the run ended after {} ticks, and the first 20 only warm up\n"
FAILED = "stage 'sensor' (door.sensor) failed at 0.40 s: worn <b>out</b>\n"
RAISED_AT, MORE = RAISED.splitlines(keepends=True)


@pytest.mark.parametrize(
    ("options", "status", "said"),
    [
        ("--until 1", 1, NOTHING.format(11) + "  let it run longer, with --until or a longer input\n"),
        ("--set sensor.grief=raise", 1, FAILED + RAISED_AT + NOTHING.format(4) + MORE),
        ("--set sensor.grief=interrupt", 130, NOTHING.format(5)),
        (
            "--flame no/a.svg",
            2,
            "--flame: cannot write no/a.svg: there is no folder no\n  choose another file with --flame\n",
        ),
        ("--flame .", 2, "--flame: cannot write .: it is a folder\n  choose another file with --flame\n"),
        ("-o toy.yaml", 2, "toy.yaml is a file\n  choose another folder with -o\n"),
        (
            "--set sensor.ticksy=1",
            2,
            "--set sensor.ticksy=1: door.sensor has no parameter 'ticksy'\n  did you mean 'ticks'?\n",
        ),
    ],
)
def test_a_run_without_a_profile_says_why(
    graph: str, options: str, status: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["profile", graph, *options.split()]) == status
    assert capsys.readouterr() == ("", said)
    assert sorted(path.name for path in Path().iterdir()) == ["door_stages.py", "toy.yaml"]


def test_a_live_graph_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("live.yaml").write_text(
        "inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}\n"
        "stages:\n  f: {use: flow.lucas_kanade, in: {image: camera.image}}\n"
    )
    assert main(["profile", "live.yaml"]) == 2
    assert capsys.readouterr().err == (
        "live.yaml: a profile is taken in lockstep, but this graph has live inputs: camera.image\n"
        "  run it with 'graphnav run'; 'graphnav top' shows the times of its steps\n"
    )


def test_a_file_that_becomes_unwritable_is_reported_after_the_tables(
    graph: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphnav.develop.commands.profile._check_file", Path.mkdir)
    assert main(["profile", graph, "--flame", "flame.svg"]) == 2
    out, err = capsys.readouterr()
    assert "clock readings a tick" in out
    assert err == "--flame: cannot write flame.svg: Is a directory\n  choose another file with --flame\n"
