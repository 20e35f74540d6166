"""``graphnav.run``: the same run as the command makes, from scripts, threads and event loops."""

from __future__ import annotations

import asyncio
import gc
import json
import logging
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_info

import graphnav
from graphnav.core.cli import main

RunToy = Callable[..., graphnav.Run]


def test_a_run_says_what_its_summary_file_says(run_toy: RunToy) -> None:
    run = run_toy(set={"sensor.ticks": 4})
    told = json.loads((run.folder / "summary.json").read_text())
    assert (run.outcome, run.failure, run.error) == (told["outcome"], "", None) == ("goal", "", None)
    assert run.metrics["way.way_m"] == told["scores"]["way"]["way_m"] == 1 + 2 + 3 + 4
    assert np.isnan(run.metrics["way.undefined"])
    assert run.summary.as_json() == told
    assert run.graph.node("sensor").params["ticks"] == 4
    assert run.check() is run


def test_it_gives_the_log_of_the_command_byte_for_byte(run_toy: RunToy, graph: Path, tmp_path: Path) -> None:
    words = ["--set", "sensor.noise_px=0.5", "--seed", "8", "--until", "2", "--no-tap", "--no-pictures"]
    assert main(["run", str(graph), *words, "-o", str(tmp_path / "out")]) == 0
    run = run_toy(set={"sensor.noise_px": 0.5}, seed=8, until_s=2, folder=tmp_path / "door")
    for name in ("run.lcmlog", "graph.yaml"):
        assert (run.folder / name).read_bytes() == (tmp_path / "out" / name).read_bytes(), name


def test_runs_in_threads_and_event_loops_are_the_same(run_toy: RunToy) -> None:
    async def in_loop() -> graphnav.Run:
        return run_toy(set={"sensor.noise_px": 1.0})

    runs = [asyncio.run(in_loop())]
    with ThreadPoolExecutor(3) as pool:
        runs += [task.result() for task in [pool.submit(run_toy, set={"sensor.noise_px": 1.0}) for _ in range(3)]]
    logs = {(run.folder / "run.lcmlog").read_bytes() for run in runs}
    assert len(logs) == 1
    assert len({run.folder for run in runs}) == 4


def test_a_run_has_one_thread_and_gives_the_others_back(run_toy: RunToy) -> None:
    before = [library["num_threads"] for library in threadpool_info()]
    barrier = threading.Barrier(2)

    def run() -> None:
        barrier.wait()
        assert run_toy().metrics["way.threads"] == 1

    with ThreadPoolExecutor(2) as pool:
        for task in [pool.submit(run) for _ in range(2)]:
            task.result()
    assert [library["num_threads"] for library in threadpool_info()] == before


def test_a_loaded_graph_runs_as_it_is(run_toy: RunToy, graph: Path) -> None:
    loaded = graphnav.load(graph, set={"sensor.ticks": 3})
    run = graphnav.run(loaded, pictures=False)
    assert run.outcome == "goal"
    assert (run.folder / "graph.yaml").read_bytes() == (
        run_toy(set={"sensor.ticks": 3}).folder / "graph.yaml"
    ).read_bytes()
    with pytest.raises(graphnav.UserError, match=r"^set and plugins have no effect on a loaded graph\n  pass them to"):
        graphnav.run(loaded, set={"sensor.ticks": 4})


def test_a_failed_run_is_returned_and_says_why(run_toy: RunToy, caplog: pytest.LogCaptureFixture) -> None:
    run = run_toy(set={"sensor.grief": "raise"})
    said = "stage 'sensor' (door.sensor) failed at 0.40 s: worn <b>out</b>"
    said += "\n  ValueError at door_stages.py:57 in _come_to_grief"
    assert (run.outcome, run.failure) == ("failed", said)
    assert caplog.record_tuples == [("graphnav", logging.WARNING, f"the run failed: {said}")]
    assert isinstance(run.error, graphnav.GraphnavError)
    assert isinstance(run.error.__cause__, ValueError)
    assert len(list(run.log.messages("sensor.twist"))) == 4
    with pytest.raises(graphnav.RunError, match=r"^stage 'sensor'") as raised:
        run.check()
    assert raised.value.run is run
    with pytest.raises(graphnav.RunError):
        run_toy(set={"sensor.grief": "raise"}, check=True)


def test_a_stage_that_exits_ends_the_run_and_not_the_caller(run_toy: RunToy) -> None:
    assert run_toy(set={"sensor.grief": "exit"}).failure.splitlines()[0].endswith("SystemExit: 7")


def test_ctrl_c_leaves_a_complete_folder_and_reaches_the_caller(run_toy: RunToy, tmp_path: Path) -> None:
    if threading.current_thread() is not threading.main_thread():
        pytest.skip("Python delivers signals to the main thread alone")
    with pytest.raises(KeyboardInterrupt):
        run_toy(set={"sensor.grief": "interrupt"}, folder=tmp_path / "out")
    log = graphnav.open_log(tmp_path / "out")
    assert len(list(log.messages("sensor.twist"))) == 5
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "stopped"


def test_a_temporary_folder_lives_as_long_as_its_run_or_log(
    run_toy: RunToy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    run = run_toy()
    folder, log = run.folder, run.log
    assert list(Path.cwd().iterdir()) == []
    del run
    gc.collect()
    assert len(list(log.messages("sensor.twist"))) == 11
    assert folder.is_dir()
    del log
    gc.collect()
    assert not folder.exists()


def test_a_named_folder_stays(run_toy: RunToy, tmp_path: Path) -> None:
    run_toy(folder=tmp_path / "a" / "b")
    gc.collect()
    assert {"run.lcmlog", "graph.yaml", "summary.json", "plugins"} == {p.name for p in (tmp_path / "a" / "b").iterdir()}


def test_printed_it_is_what_the_command_prints(run_toy: RunToy) -> None:
    run = run_toy(set={"sensor.ticks": 3})
    verdict, metric, *_, amount = str(run).splitlines()
    assert verdict == "goal reached after 0.2 s"
    assert metric.split() == ["way.way_m", "6"]
    assert amount.startswith("3 ticks, seed 3, ")
    assert repr(run) == f"<graphnav.Run toy: goal after 0.2 s, {run.folder}>"


NOT_A_GRAPH = 'graph must be a path, not 3 (int)\n  write graph="corridor_ccw"'
SET = 'write set={"plane": "plane.affine", "robot.noise_sigma_gray": 3}'


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"graph": 3}, NOT_A_GRAPH),
        ({"graph": ""}, "graph must be a path, not '' (str)\n  write graph=\"corridor_ccw\""),
        ({"graph": b"x"}, "graph must be a path, not b'x' (bytes)\n  write graph=\"corridor_ccw\""),
        ({"set": "plane=plane.affine"}, f"set must be a mapping, not 'plane=plane.affine' (str)\n  {SET}"),
        ({"set": {3: 3}}, f"set: 3 is not a stage, a parameter or a wire\n  {SET}"),
        ({"set": {"a=b": 3}}, f"set: 'a=b' is not a stage, a parameter or a wire\n  {SET}"),
        (
            {"set": {"sensor.name": {1}}},
            (
                "set['sensor.name'] must be a string, number, bool, None, path, or a list or mapping of these, "
                "not {1} (set)\n"
                "  write its name or value"
            ),
        ),
        (
            {"set": {"sensor.noise_px": "3"}},
            (
                "set['sensor.noise_px']: door.sensor: 'noise_px' must be a number, not the string '3'\n"
                "  remove the quotes"
            ),
        ),
        (
            {"set": {"sensr.noise_px": 3}},
            "set['sensr.noise_px']: there is no stage 'sensr'\n  did you mean 'sensor'?",
        ),
        ({"seed": -1}, "'seed' is -1, but must be >= 0 and <= 4294967295"),
        ({"seed": 1.5}, "'seed' must be an integer, not 1.5"),
        ({"seed": "1"}, "'seed' must be an integer, not the string '1'"),
        ({"until_s": 0}, "'until_s' is 0, but must be > 0 and <= 1000000000"),
        ({"until_s": float("nan")}, "'until_s' must be a number or null, not nan"),
        ({"folder": 3}, 'folder must be a path, not 3 (int)\n  write folder="runs/1"'),
        ({"plugins": "my.py"}, "plugins must be a list, not 'my.py' (str)\n  write plugins=[\"my_stage.py\"]"),
        ({"plugins": [3]}, 'plugins[0] must be a path, not 3 (int)\n  write plugins[0]="my_stage.py"'),
        ({"pace": "1"}, "pace must be a number or None, not '1' (str)\n  write pace=1 for wall time"),
        ({"pace": -1}, "pace is -1, but must be above 0\n  remove it to run as fast as possible"),
        (
            {"tap": True},
            'tap must be "thin", "full" or "none", not True (bool)\n  write tap="thin" to watch with graphnav spy',
        ),
        (
            {"url": 7},
            'url must be a string or None, not 7 (int)\n  write url="udpm://239.255.76.67:7667?ttl=0"',
        ),
        (
            {"url": "udpm://"},
            "url is for live runs, but this graph runs in lockstep\n  add live=True, or remove url",
        ),
        (
            {"live": True, "pace": 1},
            "pace has no effect on a live run, which runs in wall time\n  remove pace",
        ),
    ],
)
def test_a_wrong_argument_is_refused_before_anything_runs(
    graph: Path, tmp_path: Path, arguments: dict[str, Any], said: str
) -> None:
    with pytest.raises(graphnav.UserError) as error:
        graphnav.run(**({"graph": graph, "folder": tmp_path / "out"} | arguments))
    assert str(error.value) == said
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_used_is_refused(run_toy: RunToy, graph: Path, tmp_path: Path) -> None:
    for folder, said in (
        (tmp_path, f"folder: {tmp_path} is not empty\n  choose another folder, or remove this one"),
        (graph, f"folder: {graph} is a file\n  choose another folder"),
        (graph / "x", f"folder: cannot create {graph / 'x'}: Not a directory\n  choose another folder"),
        (
            tmp_path / ("x" * 300),
            f"folder: cannot create {tmp_path / ('x' * 300)}: File name too long\n  choose another",
        ),
    ):
        with pytest.raises(graphnav.UserError) as error:
            run_toy(folder=folder)
        assert str(error.value).startswith(said)


def test_a_plugin_is_read_again_by_every_call(tmp_path: Path) -> None:
    stage, graph = tmp_path / "mine.py", tmp_path / "graph.yaml"
    graph.write_text("run: {until_s: 0.5}\nstages: {c: {use: mine.still}}\n")
    for v_mps in (1.0, 22.0):
        stage.write_text(
            "from graphnav import Source, Stage, Twist, hookimpl\n\n\n"
            'class Still(Source):\n    """Says one thing."""\n\n'
            f"    def step(self) -> Twist:\n        return Twist(v_mps={v_mps}, omega_radps=0.0)\n\n\n"
            "@hookimpl\ndef graphnav_stages() -> list[type[Stage]]:\n    return [Still]\n"
        )
        run = graphnav.run(graph, plugins=[stage], pictures=False)
        assert set(run.log.stack("c.twist", "v_mps").values) == {v_mps}
