"""``graphnav.run`` live: it returns however the run ends, from the main thread and from another one."""

from __future__ import annotations

import shutil
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import graphnav

STAGES = Path(__file__).parents[1] / "core" / "api" / "door_stages.py"
GRAPH = """\
plugins: [door_stages.py]
stages:
  sensor: {use: door.sensor}
  way: {use: door.way, in: {twist: sensor.twist}}
"""


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    """Return the file of a graph that never ends by itself."""
    path = tmp_path / "toy.yaml"
    path.write_text(GRAPH)
    shutil.copy(STAGES, tmp_path)
    return path


def test_a_live_run_in_a_thread_ends_in_time(graph: Path, group: str) -> None:
    with ThreadPoolExecutor(1) as pool:
        run = pool.submit(graphnav.run, graph, live=True, url=group, until_s=0.4, pictures=False).result()
    assert run.outcome == "timeout"
    assert run.summary.live is not None
    assert run.summary.live["url"].startswith(group)
    times_s, v_mps = run.log.stack("sensor.twist", "v_mps")
    assert v_mps.tolist() == list(range(1, v_mps.size + 1))
    assert np.all((times_s >= 0) & (times_s < 60))
    assert run.metrics["way.way_m"] in np.cumsum(v_mps)  # the last one may not be stepped with any more


def test_ctrl_c_ends_a_live_run_and_returns_it(graph: Path, group: str) -> None:
    if threading.current_thread() is not threading.main_thread():
        pytest.skip("Python delivers signals to the main thread alone")
    run = graphnav.run(graph, set={"sensor.grief": "interrupt"}, live=True, url=group, pictures=False)
    assert run.outcome == "stopped"
    assert run.log.stack("sensor.twist", "v_mps").values[-1] >= 4


def test_a_url_that_leads_nowhere_is_refused_before_anything_runs(graph: Path, tmp_path: Path) -> None:
    with pytest.raises(graphnav.UserError, match=r"^url: 'tcp://x' is not a udpm:// URL\n  write udpm://"):
        graphnav.run(graph, live=True, url="tcp://x", folder=tmp_path / "out")
    assert not (tmp_path / "out").exists()
