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

from acceptance.drives import GRAPHNAV, say
from acceptance.processes import group_url
from graphnav.core.cli import commands
from graphnav.core.record import LOG, Recording

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
    port: int = 0
    """Of the server whose URL the graph of the scene "stream" names."""

    def words(self, scene: str) -> dict[str, list[str]]:
        """Return command lines for a scene by command; commands that have no use for it are missing."""
        if scene == "study":
            return {"ablate": ["ablate", "--report", "study"], **_on_run(STUDY_RUN)}
        if scene in ("changed run", "added file"):
            run = scene.partition(" ")[0]
            return {**_on_graph(f"{run}/graph.yaml"), **_on_run(run)}
        return {**_on_graph(f"{scene}/mine.yaml"), **(_in_any() if scene == "graph" else {})}

    def has_run(self) -> bool:
        """Return whether code has run since the last call."""
        found = self.marker.exists()
        self.marker.unlink(missing_ok=True)
        return found


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


def plant(folder: Path, port: int, graphnav: Sequence[str]) -> Planted:
    """Make the folders of all scenes; ``graphnav`` is the command that makes runs of the user's own."""
    marker = folder / "marker"
    evil = {scene: f"open({str(marker)!r}, 'w').close()  # {scene}\n{PLUGIN}" for scene in SCENES}
    for name in (*SCENES, "own"):
        if " " not in name and name != "study":
            (folder / name).mkdir()
            (folder / name / "mine.yaml").write_text(GRAPH, encoding="utf-8")
    (folder / "own" / "mine.py").write_text(PLUGIN, encoding="utf-8")
    for run in ("changed", "added"):
        _done([*graphnav, "run", "own/mine.yaml", *QUIET, "-o", run], folder)
    _done([*graphnav, "ablate", "own/mine.yaml", *VARY, "-o", "study"], folder)
    for run in ("changed", "added"):
        with Recording(folder / run / LOG) as recording:
            if not recording.lacks("painter.image"):
                raise SystemExit(f"the log of {run} lacks no messages")
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
    return Planted(folder, marker, port)


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


def trust_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Start every command on every scene, without consent; print what ran: only what the user names."""
    passed, n_fine, n_tried = True, 0, 0
    tried: set[str] = set()
    with tempfile.TemporaryDirectory() as scratch, requests_heard() as (port, heard):
        os.environ["XDG_STATE_HOME"] = f"{scratch}/state"
        os.environ["XDG_CACHE_HOME"] = f"{scratch}/cache"
        os.environ["LCM_DEFAULT_URL"] = group_url(76)
        folder = Path(scratch) / "work"
        folder.mkdir()
        planted = plant(folder, port, [str(GRAPHNAV)])
        for scene in SCENES:
            words_of = planted.words(scene)
            for command in sorted(words_of, key=RUNS.__contains__):
                words = words_of[command]
                tried.add(command.partition(" ")[0])
                start = (
                    [sys.executable, "-c", OPEN_LOG, *words[1:]] if command == "open_log" else [str(GRAPHNAV), *words]
                )
                status, said = _status(start, folder / ("graph" if command in _in_any() else ""))
                ran, asked = planted.has_run(), len(heard)
                heard.clear()
                may = command in RUNS and "--report" not in words and scene != "escape"
                fine = not (ran or asked) or may or (command == "profile" and scene == "stream")
                effect = "code ran" if ran else f"{asked} requests" if asked else "nothing ran"
                if command in COMPLETED and scene != "study":  # whose logs have no messages that can be made again
                    fine &= LEAVES_OUT in said
                    effect += ", says what is not made again" if LEAVES_OUT in said else ", SAYS NOTHING"
                passed &= fine
                n_fine, n_tried = n_fine + fine, n_tried + 1
                _say(fine, f"{scene}: {' '.join(words)}", f"{effect}{', as the user says' if may else ''}; {status}")
    say(f"{n_fine} of {n_tried} command lines as they should be")
    missing = set(commands()) - tried
    _say(not missing, "commands tried", f"{len(tried & set(commands()))} of {len(commands())} {', '.join(missing)}")
    return passed and not missing


def _say(fine: bool, what: str, found: str) -> None:  # noqa: FBT001
    say(f"{'ok' if fine else 'BAD':4} {what:60} {found}")


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
