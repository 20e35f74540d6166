"""A live robot and its navigation graph in processes of their own, with a relay between them."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from acceptance.drives import GRAPHNAV, Summary

RELAY = Path(__file__).with_name("relay.py")
MAX_DRIVE_S = 150.0


class Rig:
    """While entered, a world drives live; `navigate` starts (or starts again) what steers it.

    ``number`` chooses the multicast groups: rigs of different numbers do not hear each other. The robot's folder is
    ``folder/robot``, those of the navigation graph ``folder/navigation-N``.
    """

    def __init__(self, folder: Path, number: int, seed: int, robot_options: Sequence[str] = ()) -> None:
        self.folder = folder
        self.robot_url, self.graph_url = (
            f"udpm://239.255.{80 + side}.{number}:{7900 + number}?ttl=0" for side in (0, 1)
        )
        command = ["run", "robot_live", "--seed", str(seed), "--url", self.robot_url, "--until", str(MAX_DRIVE_S)]
        command += ["--no-tap", "--no-pictures", "--json", "-o", str(folder / "robot"), *robot_options]
        self._robot = _start([str(GRAPHNAV), *command], folder / "robot.txt")
        relay = [sys.executable, str(RELAY), self.robot_url, self.graph_url]
        self._relay = subprocess.Popen(relay, stdin=subprocess.PIPE, text=True)
        self.navigation: list[subprocess.Popen[bytes]] = []

    def navigate(self, graph: str = "navigate_live", options: Sequence[str] = ()) -> subprocess.Popen[bytes]:
        """Start the navigation graph."""
        run = self.folder / f"navigation-{len(self.navigation)}"
        command = [str(GRAPHNAV), "run", graph, "--url", self.graph_url, "--no-tap", "--no-pictures", "--json"]
        started = _start([*command, "-o", str(run), *options], run.with_suffix(".txt"))
        self.navigation.append(started)
        return started

    def fault(self, fault: Mapping[str, Any]) -> None:
        """Tell the relay what to do to the camera from now on; nothing for an empty mapping."""
        assert self._relay.stdin is not None
        self._relay.stdin.write(json.dumps(fault) + "\n")
        self._relay.stdin.flush()

    @property
    def is_driving(self) -> bool:
        """Whether the robot's run goes on."""
        return self._robot.poll() is None

    def finish(self, timeout_s: float = MAX_DRIVE_S + 30) -> tuple[Summary, Summary]:
        """Wait for the end of the drive; return the summaries of the robot and of the last navigation run."""
        self._robot.wait(timeout_s)
        self.navigation[-1].terminate()
        self.navigation[-1].wait(30)
        return _summary(self.folder / "robot"), _summary(self.folder / f"navigation-{len(self.navigation) - 1}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        processes: list[subprocess.Popen[Any]] = [*self.navigation, self._robot, self._relay]
        for process in processes:
            if process.poll() is None:
                process.terminate()
                try:
                    process.wait(5)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


def _start(command: Sequence[str], output: Path) -> subprocess.Popen[bytes]:
    output.parent.mkdir(parents=True, exist_ok=True)
    with output.open("wb") as file:
        return subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)


def _summary(folder: Path) -> Summary:
    summary: Summary = json.loads((folder / "summary.json").read_text())
    return summary
