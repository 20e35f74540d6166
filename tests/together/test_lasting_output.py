"""A command whose reader leaves, as ``head -1`` does, does all the same what it is for."""

from __future__ import annotations

import json
import subprocess
import sysconfig
from pathlib import Path

import pytest

from graphnav.core.codec import encode
from graphnav.core.messages import Twist
from graphnav.core.record import LogWriter, Recording

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
STAGES = Path(__file__).parent.parent / "core" / "runner" / "stages.py"
FAILING = """
run: {until_s: 2}
stages:
  c: {use: probe.counter}
  b: {use: probe.bad, in: {twist: c.twist}}
"""


def left_by_its_reader(*words: str | Path, lines: int = 0, stderr: int = subprocess.PIPE) -> tuple[int, str]:
    """Return the status of a command whose output is not read after some lines, and its stderr."""
    with subprocess.Popen([GRAPHNAV, *words], stdout=subprocess.PIPE, stderr=stderr, text=True) as process:
        assert process.stdout is not None
        for _ in range(lines):
            assert process.stdout.readline()
        process.stdout.close()
        said = process.stderr.read() if process.stderr is not None else ""
        return process.wait(60), said.strip()


@pytest.mark.parametrize(("lines", "stderr"), [(1, subprocess.PIPE), (0, subprocess.STDOUT)])
def test_a_run_goes_on_and_is_drawn(tmp_path: Path, lines: int, stderr: int) -> None:
    out = tmp_path / "out"
    words = ("run", "corridor_ccw", "--until", "0.3", "--set", "flow=flow.dis", "--no-tap", "-o", out)
    assert left_by_its_reader(*words, lines=lines, stderr=stderr) == (0, "")
    files = {"run.lcmlog", "graph.yaml", "summary.json", "map.png", "panels.png"}
    assert {path.name for path in out.iterdir()} == files
    assert json.loads((out / "summary.json").read_text())["outcome"] == "timeout"
    assert Recording(out / "run.lcmlog").truncated is None


def test_a_run_that_fails_has_its_own_status_and_says_why(tmp_path: Path) -> None:
    (tmp_path / "graph.yaml").write_text(FAILING)
    words = ("run", tmp_path / "graph.yaml", "--plugin", STAGES, "--no-tap", "--json", "-o", tmp_path / "out")
    status, said = left_by_its_reader(*words)
    assert status == 1
    assert said.splitlines()[0].startswith("stage 'b' (probe.bad) failed at 0.30 s: ")
    assert "pipe" not in said
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "failed"


@pytest.mark.parametrize("words", [["schema"], ["stages"], ["check", "corridor_ccw"], ["--help"]])
def test_what_only_prints_is_done_then(words: list[str]) -> None:
    assert left_by_its_reader(*words) == (0, "")


def test_what_listens_ends(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        for k in range(10_000):
            log.write("twist", k, encode(Twist(0.5, 0.0), k, k))
    assert left_by_its_reader("echo", "twist", tmp_path / "log", lines=1) == (141, "")
    for command in ("info", "hz", "bw", "spy"):  # their tables are printed by rich, which exits with 1 by itself
        assert left_by_its_reader(command, tmp_path / "log") == (141, ""), command
