"""``graphnav replay``: what it prints, its exit status, and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.messages import About
from graphnav.core.record import LogWriter, Recording
from graphnav.core.run_folder import RunFolder

PLUGIN = """
import numpy as np

from graphnav import Metric, Source, Stage, Twist, hookimpl

FAMILY = "mine"
SCALE = 1.0


class Dice(Source):
    \"\"\"Throws.\"\"\"

    def reset(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)

    def step(self) -> Twist:
        return Twist(v_mps=float(self._random.integers(6)), omega_radps=0.0)


class Sum(Stage):
    \"\"\"Adds up.\"\"\"

    metrics = (Metric("sum_mps", unit="m/s", better="higher", help="The sum."),)

    def reset(self, seed: int) -> None:
        self._sum = 0.0
        self._steps = 0

    def step(self, twist: Twist) -> Twist:
        self._steps += 1
        self._sum += twist.v_mps * (SCALE if self._steps > 5 else 1.0)
        return Twist(v_mps=self._sum, omega_radps=0.0)

    def summary(self) -> dict[str, float]:
        return {"sum_mps": self._sum}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Dice, Sum]
"""
GRAPH = "run: {until_s: 2, seed: 3}\nstages:\n  dice: {use: mine.dice}\n  sum: {use: mine.sum, in: {twist: dice}}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """Return the folder of a recorded run with a one-file plugin, in the working folder."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(PLUGIN)
    Path("graph.yaml").write_text(GRAPH)
    words = ["run", "graph.yaml", "--plugin", "mine.py", "--no-tap", "--no-pictures", "-o", "run"]
    assert main(words) == 0
    capsys.readouterr()
    return Path("run")


def test_no_differences(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(folder)]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    lines = [line.rstrip() for line in said.out.splitlines()]
    assert lines[0].startswith("2.0 s replayed in ")
    assert lines[0].endswith(" x), 21 ticks")
    assert lines[1:3] == ["played: dice.twist", "stepped: sum"]
    assert lines[-1] == "no differences: 21 messages on 1 channel compared"
    assert lines[-2] == "1 metric as recorded"


def test_a_plugin_that_changed_takes_the_place_of_the_recorded_one(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("mine.py").write_text(PLUGIN.replace("SCALE = 1.0", "SCALE = 2.0"))
    assert main(["replay", str(folder)]) == 0, "the folder has a copy of the plugin"
    capsys.readouterr()
    assert main(["replay", str(folder), "--plugin", "mine.py"]) == 1
    said = capsys.readouterr()
    last = said.out.splitlines()[-1]
    assert last.startswith("1 channel of 1 differ: first sum.twist at 0.50 s, v_mps: recorded ")
    assert any(line.split()[:2] == ["sum", "sum_mps"] for line in said.out.splitlines())
    assert main(["replay", str(folder), "--plugin", "mine.py", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["equal"], found["first"]["channel"], found["first"]["at_s"]) == (False, "sum.twist", 0.5)
    assert found["channels"]["sum.twist"]["fields"]["v_mps"]["differing"] == 16
    assert found["scores"]["sum"]["sum_mps"] > found["recorded_scores"]["sum"]["sum_mps"]


def test_a_log_alone_loads_no_plugin(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / RunFolder.LOG).rename("alone.lcmlog")
    Path("graph.yaml").write_text("plugins: [mine.py]\n" + GRAPH)
    assert main(["run", "graph.yaml", "--no-tap", "--no-pictures", "-o", "named"]) == 0
    (Path("named") / RunFolder.LOG).rename("named.lcmlog")
    capsys.readouterr()
    assert main(["replay", "named.lcmlog"]) == 2
    assert capsys.readouterr().err == (
        "named.lcmlog (graphnav.about): the graph of this log needs the plugin 'mine.py'\n"
        "  name the file with --plugin FILE\n"
    )
    assert main(["replay", "named.lcmlog", "--plugin", "mine.py"]) == 0
    assert main(["replay", "alone.lcmlog"]) == 2
    assert "there is no family 'mine'" in capsys.readouterr().err


def test_a_hostile_description_loads_nothing_and_is_printed_as_text(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("evil.py").write_text("raise SystemExit('imported')")
    Path("evil.yaml").write_text("plugins: [evil.py]\nstages: {}\n")
    said = {
        "extends: evil.yaml\nstages: {}\n": "the graph of this log extends another graph",
        "plugins: [evil.py]\nstages: {}\n": "the graph of this log needs the plugin 'evil.py'",
        'stages: {a: {use: "\\e[31mx.y"}}\n': "there is no family '\\x1b[31mx'",
        "stages: [": "hostile.lcmlog (graphnav.about):1:10: YAML: ",
    }
    with Recording(folder / RunFolder.LOG) as recording:
        assert recording.about is not None
        about = recording.about
        for text, error in said.items():
            with LogWriter("hostile.lcmlog") as writer:
                writer.write(About.CHANNEL, 0, encode(replace(about, graph_yaml=text), 0, 0))
            assert main(["replay", "hostile.lcmlog"]) == 2
            told = capsys.readouterr().err
            assert error in told
            assert all(char.isprintable() or char == "\n" for char in told)


def test_the_log_of_the_replay(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(folder), "-o", "again.lcmlog"]) == 0
    assert main(["replay", "again.lcmlog", "--plugin", "mine.py", "--json"]) == 0
    capsys.readouterr()
    assert main(["replay", str(folder), "-o", "again.lcmlog"]) == 2
    assert capsys.readouterr().err == "again.lcmlog already exists\n  choose another file with -o\n"
    assert main(["replay", str(folder), "-o", "no/again.lcmlog"]) == 2
    assert capsys.readouterr().err.startswith("cannot write no/again.lcmlog: No such file or directory\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--cold"], "--cold starts at --from with fresh state, but there is no --from\n  add --from S\n"),
        (["--from", "9s"], "run/run.lcmlog ends at 2.00 s\n  --from 9 is after the end\n"),
        (["--play", "sum"], "no stage is left to step: every channel is played\n  leave out some of --play\n"),
        (["--play", "sun.twist"], "--play: the graph has no channel 'sun.twist'\n  did you mean 'sum.twist'?\n"),
        (["--set", "sum=mine.dice"], None),
        (["--graph", "none.yaml"], "none.yaml: there is no such graph\n"),
    ],
)
def test_what_is_asked_for_wrongly_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str | None
) -> None:
    assert main(["replay", str(folder), *words]) == 2
    error = capsys.readouterr().err
    assert "Traceback" not in error
    assert said is None or error.startswith(said)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--from", "soon"], "argument --from: 'soon' is not a time in seconds: write 12.3s"),
        (["--from", "nan"], "argument --from: 'nan' is not a time in seconds: write 12.3s"),
        (["--tolerance", "1,2,3"], "argument --tolerance: '1,2,3' is not a tolerance: write 1e-6, or 1e-6,1e-3 "),
        (["--tolerance", "-1"], "argument --tolerance: "),
        (["--play", "a,,b"], "argument --play: 'a,,b' does not list channels: write flow.flow,planar.planar"),
    ],
)
def test_options_that_are_no_values(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["replay", str(folder), *words])
    assert caught.value.code == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("none", "there is no none\n  name a run folder or a log\n"),
        (".", ". holds no run.lcmlog\n  name a run folder or a log\n"),
        ("graph.yaml", "graph.yaml is not an LCM log\n  name a run folder, or a log\n"),
    ],
)
def test_what_is_no_log_is_refused(folder: Path, capsys: pytest.CaptureFixture[str], name: str, said: str) -> None:
    assert main(["replay", name]) == 2
    assert capsys.readouterr().err == said


def test_a_source_that_is_swapped_is_played_all_the_same(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", str(folder), "--set", "dice.rate_hz=5"]) == 0
    assert capsys.readouterr().err == (
        "dice: --set has no effect on this stage, because it does not step in this replay\n"
    )
