"""It can be watched: another process sees every channel of a paced run, live."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tests.forked_commands import forked_graphnav


@pytest.mark.usefixtures("group")
def test_a_spy_sees_every_channel_with_type_rate_size_and_fields(tmp_path: Path) -> None:
    graphnav = str(forked_graphnav())
    words = [graphnav, "run", "corridor_ccw", "--pace", "1", "--until", "60", "--no-pictures", "-o", "out"]
    run = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert run.stdout is not None
        run_id = run.stdout.readline().split()[1]
        spied = subprocess.run(
            [graphnav, "spy", "--once", "--json", "--for", "8"], capture_output=True, text=True, check=True
        )
        echoed = subprocess.run(
            [graphnav, "echo", "flow.flow", "-n", "1", "--for", "8"], capture_output=True, text=True, check=True
        )
    finally:
        run.terminate()
        run.communicate()
    assert run_id in spied.stdout
    channels = json.loads(spied.stdout)["channels"]
    about = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert {"robot.image", "robot.map", "flow.flow", "planar.planar", "plane.plane", "steer.steering"} <= set(channels)
    assert {name.partition(".")[0] for name in channels} - {"graphnav"} <= set(about["stages"])
    for name, channel in channels.items():
        assert channel["type"].startswith("graphnav_lcm."), name
        assert channel["fields"], name
        if name == "plane.components":
            assert channel["bytes"] == 0, "made only where a stage reads it"
            continue
        assert channel["bytes"] > 0, name
        if name not in {"graphnav.about", "graphnav.status", "robot.map", "robot.limits"}:
            assert channel["rate_hz"] == pytest.approx(10.0, rel=0.02), name
    assert "uv_px" in echoed.stdout
    assert len(echoed.stdout) < 1000, "arrays are summarised, never dumped"
