"""A live run whose stage misbehaves or hangs ends with status 1, its log and its summary."""

from __future__ import annotations

import json
import os
import subprocess
import sysconfig
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.record import LOG

TOOLS = Path(__file__).parents[2] / "tools"
ZOO = TOOLS / "attacks" / "zoo_stages.py"
GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"


@pytest.mark.parametrize(
    ("use", "said"),
    [
        ("sleeper", "step did not return within 1 s of wall time; given twist of 'c.twist'"),
        ("animal, with: {kind: ctrl_c, method: step}", "KeyboardInterrupt"),
        ("animal, with: {kind: exit_0, method: step}", "SystemExit: 0"),
    ],
)
def test_a_live_run_ends_with_the_stage_its_log_and_its_summary(
    tmp_path: Path, group: str, use: str, said: str
) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text(f"stages:\n  c: {{use: zoo.clock}}\n  b: {{use: zoo.{use}, in: {{twist: c.twist}}}}\n")
    command = [str(GRAPHNAV), "run", "graph.yaml", "--plugin", str(ZOO), "--no-tap", "--no-pictures", "-o", "out"]
    command += ["--live", "--url", group, "--stall-s", "1"]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(TOOLS)}
    )
    assert done.returncode == 1, done.stdout + done.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["cause"] == f"stage 'b' (zoo.{use.partition(',')[0]}) failed: {said}"
    assert summary["failure"] in done.stderr
    assert "Traceback" not in done.stderr
    with Recording(tmp_path / "out" / LOG) as log:
        assert log.truncated is None
        assert log.count("c.twist") >= 3
