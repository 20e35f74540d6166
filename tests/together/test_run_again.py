"""A run folder's ``graph.yaml`` runs again, from any folder and without the plugins' own files."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.cli import main
from graphnav.core.messages import About
from graphnav.core.run_folder import RunFolder

SOURCE = """
import numpy as np

from graphnav import Source, Stage, Twist, hookimpl, param


class Dice(Source):
    sides: int = param(6, ge=1, doc="what is thrown")

    def reset(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)

    def step(self) -> Twist:
        return Twist(v_mps=float(self._random.integers(self.sides)), omega_radps=0.0)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Dice]
"""
QUIET = ["--no-tap", "--no-pictures"]


def said_in(folder: Path) -> list[tuple[str, int, bytes]]:
    """Return everything in a run's log but how it describes itself."""
    with Recording(folder / RunFolder.LOG) as log:
        return [(event.channel, event.utime, event.data) for event in log.events() if event.channel != About.CHANNEL]


@pytest.fixture
def graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a graph that extends another and names a plugin; the family of each plugin is its file's name."""
    monkeypatch.chdir(tmp_path)
    for folder in ("lib", "mine", "mine/more"):
        (tmp_path / folder).mkdir()
    (tmp_path / "lib" / "one.py").write_text(SOURCE)
    (tmp_path / "mine" / "two.py").write_text(SOURCE.replace("Dice", "Coin"))
    (tmp_path / "lib" / "base.yaml").write_text(
        "plugins: [one.py]\nrun: {until_s: 2}\nstages: {dice: {use: one.dice}}\n"
    )
    (tmp_path / "mine" / "graph.yaml").write_text("extends: ../lib/base.yaml\nrun: {seed: 5}\n")
    return tmp_path / "mine" / "graph.yaml"


def test_it_gives_the_same_log(graph: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options = ["--plugin", "mine/two.py", "--plugin", "lib/one.py", "--set", "coin+=two.coin", "--set", "dice.sides=9"]
    assert main(["run", str(graph), *options, *QUIET, "-o", "first"]) == 0
    assert sorted(p.name for p in Path("first/plugins").iterdir()) == ["one.py", "two.py"]
    shutil.rmtree("lib")
    shutil.rmtree("mine")
    shutil.move("first", "moved")
    monkeypatch.chdir("/")
    assert main(["run", str(tmp_path / "moved" / "graph.yaml"), *QUIET, "-o", str(tmp_path / "second")]) == 0
    assert main(["run", str(tmp_path / "second" / "graph.yaml"), *QUIET, "-o", str(tmp_path / "third")]) == 0
    first = said_in(tmp_path / "moved")
    assert {channel for channel, _, _ in first} == {"dice.twist", "coin.twist"}
    assert said_in(tmp_path / "second") == said_in(tmp_path / "third") == first
    logs = [(tmp_path / name / RunFolder.LOG).read_bytes() for name in ("second", "third")]
    assert logs[0] == logs[1]


def test_files_of_one_name_keep_their_family(tmp_path: Path, graph: Path) -> None:
    for name in ("a", "b"):
        (graph.parent / name).mkdir()
        (graph.parent / name / "same.py").write_text(SOURCE.replace("Dice", f"Dice{name.upper()}"))
    graph.write_text("plugins: [a/same.py, b/same.py]\nrun: {until_s: 1}\nstages: {x: {use: same.dice_a}}\n")
    assert main(["run", str(graph), "--set", "y+=same.dice_b", *QUIET, "-o", "first"]) == 0
    text = Path("first/graph.yaml").read_text()
    assert "plugins: [plugins/same.py, plugins/2/same.py]\n" in text
    assert main(["run", "first/graph.yaml", *QUIET, "-o", "second"]) == 0
    assert said_in(Path("first")) == said_in(Path("second"))


def test_what_the_log_says_of_itself_is_the_same_wherever_the_files_are(tmp_path: Path, graph: Path) -> None:
    shutil.copytree(tmp_path / "lib", tmp_path / "elsewhere" / "lib")
    shutil.copytree(tmp_path / "mine", tmp_path / "elsewhere" / "mine")
    assert main(["run", str(graph), *QUIET, "-o", "here"]) == 0
    assert main(["run", "elsewhere/mine/graph.yaml", *QUIET, "-o", "there"]) == 0
    assert Path("here", RunFolder.LOG).read_bytes() == Path("there", RunFolder.LOG).read_bytes()
    with Recording(Path("here", RunFolder.LOG)) as log:
        assert log.about is not None
        assert "plugins: [one.py]\n" in log.about.graph_yaml
        assert str(tmp_path) not in log.about.graph_yaml


def test_a_resolved_graph_names_the_plugins_of_the_command_line(
    graph: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["check", str(graph), "--resolved", "--trust", "--plugin", "mine/two.py", "--set", "coin+=two.coin"]
    assert main(words) == 0
    Path("mine/more/h.yaml").write_text(capsys.readouterr().out)
    monkeypatch.chdir("mine/more")
    assert main(["check", "h", "--plugin", "../two.py", "--plugin", "../../lib/one.py"]) == 0
    assert f"plugins: [{tmp_path}/lib/one.py, {tmp_path}/mine/two.py]\n" in Path("h.yaml").read_text()


def test_a_plugin_that_is_gone_before_the_run_begins_is_a_users_error(tmp_path: Path, graph: Path) -> None:
    plugin = tmp_path / "lib" / "one.py"
    plugin.write_text(f"import os\n{SOURCE}\nos.remove(__file__)\n")
    assert main(["run", str(graph), *QUIET, "-o", "out"]) == 2
    assert not (tmp_path / "out" / RunFolder.LOG).exists()


def test_runs_of_a_study_run_again(graph: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = tmp_path / "mine" / "study.yaml"
    study.write_text(
        "graph: graph\nseeds: 0:2\nset: {coin+: two.coin}\n"
        "vary: {sides: {few: {dice.sides: 2}, many: {dice.sides: 9, third+: two.coin}}, coin: [two.coin, one.dice]}\n"
    )
    out = tmp_path / "out"
    assert main(["ablate", str(study), "--plugin", "mine/two.py", "-j", "1", "--gallery", "0", "-o", str(out)]) == 0
    plan = json.loads((out / "plan.json").read_text())
    assert plan["plugins"] == [str(tmp_path / "mine" / "two.py"), str(tmp_path / "lib" / "one.py")]
    runs = sorted(path.parent for path in out.rglob("graph.yaml"))
    assert len(runs) == 8
    assert {path.name for path in (runs[0] / "plugins").iterdir()} == {"one.py", "two.py"}
    shutil.rmtree(tmp_path / "lib")
    shutil.rmtree(tmp_path / "mine")
    monkeypatch.chdir("/")
    assert main(["run", str(runs[-1] / "graph.yaml"), *QUIET, "-o", str(tmp_path / "again")]) == 0
    assert said_in(tmp_path / "again") == said_in(runs[-1])
    assert "third.twist" in {channel for channel, _, _ in said_in(runs[-1])}
