"""A live run whose stage misbehaves or hangs ends with status 1, its log and its summary."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.run_folder import RunFolder
from tests.forked_commands import forked_graphnav

PLUGIN = Path(__file__).parents[1] / "core" / "runner" / "misbehaving.py"
GRAPH = """
stages:
  c: {use: odd.clock}
  b: {use: odd.faulty, with: {kind: %s, method: step}, in: {twist: c.twist}}
"""


@pytest.mark.parametrize(
    ("kind", "said", "options"),
    [
        ("hang", "step did not return within 1 s of wall time; given twist of 'c.twist'", ()),
        ("hang", "step did not return within 1 s of wall time; given twist of 'c.twist'", ("--processes",)),
        ("ctrl_c", "KeyboardInterrupt", ()),
        ("exit_0", "SystemExit: 0", ()),
        ("exit_0", "SystemExit: 0", ("--processes",)),
    ],
)
def test_a_live_run_ends_with_the_stage_its_log_and_its_summary(
    tmp_path: Path, group: str, kind: str, said: str, options: Sequence[str]
) -> None:
    (tmp_path / "graph.yaml").write_text(GRAPH % kind)
    command = [
        str(forked_graphnav()),
        "run",
        "graph.yaml",
        "--plugin",
        str(PLUGIN),
        "--no-tap",
        "--no-pictures",
        "-o",
        "out",
    ]
    command += ["--live", "--url", group, "--stall-s", "1", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 1, done.stdout + done.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["cause"] == f"stage 'b' (odd.faulty) failed: {said}"
    assert summary["failure"] in done.stderr
    assert "Traceback" not in done.stderr
    with Recording(tmp_path / "out" / RunFolder.LOG) as log:
        assert log.truncated is None
        assert log.count("c.twist") >= 3
