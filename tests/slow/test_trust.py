"""Reading runs nothing: every command on folders with planted plugins, with what ran and how it ended."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import group_url

from graphnav.core.cli import commands
from graphnav.core.record import Recording
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

PLUGIN = """
import numpy as np

from graphnav import Image, Metric, Source, Stage, Twist, hookimpl, param


class Wheels(Source):
    metrics = (Metric("way_m", unit="m", better="higher", help="The way driven."),)
    speed_mps: float = param(0.1, doc="the speed")

    def step(self) -> Twist:
        return Twist(v_mps=self.speed_mps, omega_radps=0.0)

    def summary(self) -> dict[str, float]:
        return {"way_m": self.speed_mps}


class Rival(Wheels):
    pass


class Painter(Stage):
    def step(self, twist: Twist) -> Image:
        return Image(pixels=np.full((100, 100), 7, np.uint8))


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Painter, Rival, Wheels]
"""
GRAPH = """\
plugins: [mine.py]
run: {until_s: 1}
stages:
  wheels: {use: mine.wheels}
  painter: {use: mine.painter, in: {twist: wheels.twist}}
"""
QUIET = ("--no-tap", "--no-pictures")
VARY = ("--vary", "wheels=mine.wheels,mine.rival", "--seeds", "0:1")
SEARCH = ("--search", "wheels.speed_mps=0.1:1", "--trials", "2")
RUNS = ("run", "ablate", "tune", "teach")
"""Commands that run what the user names."""
STUDY_RUN = "study/runs/mine/mine.wheels/0"
SCENES = ("graph", "changed run", "added file", "study", "escape", "stream")
PATIENCE_S = 40.0
ENDLESS = ("view", "spy", "record", "lcm-spy", "teleop")
"""Commands that last until they are ended."""
SHORT_S = 8.0
COMPLETED = ("figure", "export", "spy", "view", "echo", "hz", "bw", "play", "replay --play", "open_log")
"""Commands that make again what a log leaves out, and the function of Python."""
OPEN_LOG = "import sys, graphnav\nwith graphnav.open_log(sys.argv[1]) as log: print(log.channels)"
LEAVES_OUT = (
    "does not hold its large messages, and they cannot be recomputed: its plugins are Python code that is not trusted"
)


@dataclass(frozen=True)
class Planted:
    """Folders that bring code; it leaves ``marker`` behind if it runs."""

    folder: Path
    marker: Path
    heard: list[int]
    """The connections to the server whose URL the graph of the scene "stream" names."""

    def has_run(self) -> bool:
        """Return whether code has run since the last call."""
        found = self.marker.exists()
        self.marker.unlink(missing_ok=True)
        return found


def words_of(scene: str) -> dict[str, list[str]]:
    """Return command lines for a scene by command, what runs code last; commands without a use for it are missing."""
    if scene == "study":
        lines = {"ablate": ["ablate", "--report", "study"], **_on_run(STUDY_RUN)}
    elif scene in ("changed run", "added file"):
        run = scene.partition(" ")[0]
        lines = {**_on_graph(f"{run}/graph.yaml"), **_on_run(run)}
    else:
        lines = {**_on_graph(f"{scene}/mine.yaml"), **(_in_any() if scene == "graph" else {})}
    return dict(sorted(lines.items(), key=lambda line: line[0] in RUNS))


def _on_graph(graph: str) -> dict[str, list[str]]:
    lines = {name: [name, graph] for name in ("check", "draw", "doctor", "profile")}
    lines["run"] = ["run", graph, *QUIET, "-o", "out/run"]
    lines["ablate"] = ["ablate", graph, *VARY, "-o", "out/ablate"]
    lines["tune"] = ["tune", graph, *VARY, "--metrics", "wheels.way_m", *SEARCH, "-o", "out/tune"]
    lines["teach"] = ["teach", graph, "-o", "out.lcmlog"]
    return lines


def _on_run(run: str) -> dict[str, list[str]]:
    lines = {name: [name, run] for name in ("replay", "figure", "info", "hz", "bw", "spy", "view")}
    lines["export"] = ["export", run, "--to", "csv", "-o", "out/export"]
    lines["echo"] = ["echo", "painter.image", run]
    lines["replay --play"] = ["replay", run, "--play", "painter.image"]
    lines["open_log"] = ["open_log", run]
    lines["top"] = ["top", "--once", run]
    lines["play"] = ["play", run, "--speed", "100"]
    return lines


def _in_any() -> dict[str, list[str]]:
    """Return the commands that name no folder; they are started in that of the graph."""
    return {
        "stages": ["stages"],
        "new-stage": ["new-stage", "plane", "other"],
        "schema": ["schema"],
        "record": ["record", "-o", "own.lcmlog", "--for", "1"],
        "pub": ["pub", "X", "twist_t"],
        "teleop": ["teleop"],
        "types": ["types"],
        "lcm-spy": ["lcm-spy"],
        "trust": ["trust"],
        "completion": ["completion", "bash"],
    }


def plant(folder: Path, port: int, heard: list[int]) -> Planted:
    """Make the folders of all scenes, from runs of the user's own."""
    marker = folder / "marker"
    evil = {scene: f"open({str(marker)!r}, 'w').close()  # {scene}\n{PLUGIN}" for scene in SCENES}
    for name in (*SCENES, "own"):
        if " " not in name and name != "study":
            (folder / name).mkdir()
            (folder / name / "mine.yaml").write_text(GRAPH, encoding="utf-8")
    (folder / "own" / "mine.py").write_text(PLUGIN, encoding="utf-8")
    for run in ("changed", "added"):
        _done([str(GRAPHNAV), "run", "own/mine.yaml", *QUIET, "-o", run], folder)
    _done([str(GRAPHNAV), "ablate", "own/mine.yaml", *VARY, "-o", "study"], folder)
    for run in ("changed", "added"):
        with Recording(folder / run / RunFolder.LOG) as recording:
            if not recording.lacks("painter.image"):
                raise AssertionError(f"the log of {run} lacks no messages")
    (folder / "changed" / "plugins" / "mine.py").write_text(evil["changed run"], encoding="utf-8")
    (folder / "added" / "plugins" / "numpy.py").write_text(evil["added file"], encoding="utf-8")
    (folder / "graph" / "mine.py").write_text(evil["graph"], encoding="utf-8")
    for name in ("cv2.py", "lcm.py", "numpy.py", "yaml.py"):
        shutil.copy(folder / "graph" / "mine.py", folder / "graph" / name)
    (folder / "escape" / "link.py").symlink_to(folder / "graph" / "mine.py")
    (folder / "escape" / "mine.yaml").write_text(
        GRAPH.replace("[mine.py]", f"[../graph/mine.py, link.py, {folder}/graph/mine.py]"), encoding="utf-8"
    )
    camera = f'  wheels: {{use: io.video, with: {{path: "http://127.0.0.1:{port}/a.mp4", open_timeout_s: 2}}}}\n'
    (folder / "stream" / "mine.yaml").write_text(f"run: {{until_s: 1}}\nstages:\n{camera}", encoding="utf-8")
    plan = json.loads((folder / "study" / "plan.json").read_text(encoding="utf-8"))
    (folder / "foreign.py").write_text(evil["study"], encoding="utf-8")
    plan["plugins"] = [str(folder / "foreign.py")]
    (folder / "study" / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    for copy in (folder / "study").rglob("mine.py"):
        copy.write_text(evil["study"], encoding="utf-8")
    return Planted(folder, marker, heard)


def _done(command: Sequence[str], folder: Path) -> None:
    subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=300)


@contextlib.contextmanager
def requests_heard() -> Iterator[tuple[int, list[int]]]:
    """Yield the port of a server that answers nothing, and the list that grows with every connection to it."""
    heard: list[int] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def accept() -> None:
            with contextlib.suppress(OSError):
                while True:
                    server.accept()[0].close()
                    heard.append(1)

        threading.Thread(target=accept, daemon=True).start()
        yield server.getsockname()[1], heard
        server.shutdown(socket.SHUT_RDWR)


@pytest.fixture(scope="module")
def planted(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Planted]:
    """Plant all scenes once; only the runs of the user's own are trusted then."""
    folder = tmp_path_factory.mktemp("trust")
    with pytest.MonkeyPatch.context() as patch, requests_heard() as (port, heard):
        patch.setenv("XDG_STATE_HOME", str(folder / "state"))
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        patch.setenv("LCM_DEFAULT_URL", group_url(76))
        (folder / "work").mkdir()
        yield plant(folder / "work", port, heard)


@pytest.fixture
def untried(planted: Planted, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Planted:
    """Return the scenes for a user who has run none of them: what commands remember holds for one test."""
    shutil.copytree(planted.folder.parent / "state", tmp_path / "state")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return planted


@pytest.mark.parametrize(("scene", "command"), [(scene, command) for scene in SCENES for command in words_of(scene)])
def test_trust(targets: Targets, untried: Planted, scene: str, command: str) -> None:
    """Start a command on a scene, without consent: only what the user names runs."""
    words = words_of(scene)[command]
    start = [sys.executable, "-c", OPEN_LOG, *words[1:]] if command == "open_log" else [str(GRAPHNAV), *words]
    status, said = _status(start, untried.folder / ("graph" if command in _in_any() else ""))
    ran, asked = untried.has_run(), len(untried.heard)
    untried.heard.clear()
    may = command in RUNS and "--report" not in words and scene != "escape"
    fine = not (ran or asked) or may or (command == "profile" and scene == "stream")
    effect = "code ran" if ran else f"{asked} requests" if asked else "nothing ran"
    if command in COMPLETED and scene != "study":  # whose logs have no messages that can be made again
        fine &= LEAVES_OUT in said
        effect += ", says what is not made again" if LEAVES_OUT in said else ", SAYS NOTHING"
    text = f"{scene}: {' '.join(words)}: {effect}{', as the user says' if may else ''}; {status}"
    targets.check(text, good=fine)


def test_trust_tries_every_command() -> None:
    assert set(commands()) <= {command.partition(" ")[0] for scene in SCENES for command in words_of(scene)}


def _status(command: Sequence[str], folder: Path) -> tuple[str, str]:
    """Return how a command ends and what it says on stderr; those that last are interrupted."""
    with tempfile.TemporaryFile("w+", encoding="utf-8") as said:
        status = _ending(command, folder, said)
        said.seek(0)
        return status, said.read()


def _ending(command: Sequence[str], folder: Path, said: IO[str]) -> str:
    limit_s = SHORT_S if any(word in ENDLESS for word in command) else PATIENCE_S
    with subprocess.Popen(
        command,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=said,
        start_new_session=True,
    ) as process:
        try:
            return f"exit {process.wait(limit_s)}"
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGINT)
        try:
            return f"ended by Ctrl-C, exit {process.wait(20.0)}"
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return "killed"
