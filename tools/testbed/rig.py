"""A live robot and its navigation graph in processes of their own, with relays between them."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from testbed.drives import GRAPHNAV, Summary

TOOLS = Path(__file__).parents[1]
MAX_DRIVE_S = 150.0


class Rig:
    """While entered, a world drives live; `navigate` starts (or starts again) what steers it.

    ``number`` chooses the multicast groups: rigs of different numbers do not hear each other. The robot's folder is
    ``folder/robot``, those of the navigation graph ``folder/navigation-N``. The camera has a relay of its own.
    """

    def __init__(
        self,
        folder: Path,
        number: int,
        seed: int,
        robot_options: Sequence[str] = (),
        max_drive_s: float = MAX_DRIVE_S,
    ) -> None:
        self.folder = folder
        self.robot_url, self.graph_url = (
            f"udpm://239.255.{80 + side}.{number}:{7900 + number}?ttl=0&recv_buf_size=2097152" for side in (0, 1)
        )
        command = ["run", "robot_live", "--seed", str(seed), "--url", self.robot_url, "--until", str(max_drive_s)]
        command += ["--no-tap", "--no-pictures", "--json", "-o", str(folder / "robot"), *robot_options]
        self.robot = _start([str(GRAPHNAV), *command], folder / "robot.txt")
        self._relays = {
            "ODOMETRY": self._relay("ODOMETRY", "BEACON", "BASE_LIMITS"),
            "TELEOP": self._relay("TELEOP"),
            "STOP": self._relay("STOP"),
            "BASE_CMD": _relay(self.graph_url, self.robot_url, "BASE_CMD"),
        }
        self.start_camera()
        self.navigation: list[subprocess.Popen[bytes]] = []

    def navigate(self, graph: str = "navigate_live", options: Sequence[str] = ()) -> subprocess.Popen[bytes]:
        """Start the navigation graph."""
        run = self.folder / f"navigation-{len(self.navigation)}"
        words = navigation_words(graph, self.graph_url, run, options)
        started = _start([str(GRAPHNAV), *words], run.with_suffix(".txt"))
        self.navigation.append(started)
        return started

    def start_camera(self) -> None:
        """Start the camera's relay."""
        self._relays["CAMERA"] = self._relay("CAMERA")

    def kill_camera(self) -> None:
        """End the camera's relay at once."""
        self._relays["CAMERA"].kill()
        _wait(self._relays["CAMERA"])

    def pause_camera(self) -> None:
        """Suspend the camera's relay; what is sent to it meanwhile waits in its socket."""
        self._relays["CAMERA"].send_signal(signal.SIGSTOP)

    def resume_camera(self) -> None:
        """Let the camera's relay go on."""
        self._relays["CAMERA"].send_signal(signal.SIGCONT)

    def fault(self, fault: Mapping[str, Any], channel: str = "CAMERA") -> None:
        """Tell the relay of a channel what to do to it from now on; nothing for an empty mapping."""
        self._tell(channel, fault)

    def corrupt(self, channel: str, kind: str) -> None:
        """Let every second message of a channel be spoiled from now on; none where ``kind`` is empty."""
        self._tell(channel, {"corrupt": kind} if kind else {})

    def _tell(self, channel: str, words: Mapping[str, Any]) -> None:
        stdin = self._relays[channel].stdin
        assert stdin is not None
        stdin.write(json.dumps(words) + "\n")
        stdin.flush()

    def _relay(self, *channels: str) -> subprocess.Popen[str]:
        return _relay(self.robot_url, self.graph_url, *channels)

    @property
    def is_driving(self) -> bool:
        """Whether the robot's run goes on."""
        return self.robot.poll() is None

    def finish(self, timeout_s: float = MAX_DRIVE_S + 30) -> tuple[Summary, Summary]:
        """Wait for the end of the drive; return the summaries of the robot and of the last navigation run."""
        self.robot.wait(timeout_s)
        self.navigation[-1].terminate()
        self.navigation[-1].wait(30)
        return summary_of(self.folder / "robot"), summary_of(self.folder / f"navigation-{len(self.navigation) - 1}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.resume_camera()
        processes: list[subprocess.Popen[Any]] = [*self.navigation, self.robot, *self._relays.values()]
        for process in processes:
            if process.poll() is None:
                process.terminate()
        for process in processes:
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
            _wait(process)


def navigation_words(graph: str, url: str, run: Path, options: Sequence[str] = ()) -> list[str]:
    """Return the words of the command that steers."""
    return ["run", graph, "--url", url, "--no-tap", "--no-pictures", "--json", "-o", str(run), *options]


def summary_of(folder: Path) -> Summary:
    """Return the summary in a run's folder."""
    summary: Summary = json.loads((folder / "summary.json").read_text())
    return summary


def _relay(source_url: str, target_url: str, *channels: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "testbed.relay", source_url, target_url, *channels]
    return subprocess.Popen(command, stdin=subprocess.PIPE, text=True, cwd=TOOLS)


def _wait(process: subprocess.Popen[Any]) -> None:
    """Wait for the end of a process, and close what was its standard input."""
    process.wait()
    if process.stdin is not None:
        with suppress(BrokenPipeError):
            process.stdin.close()


def _start(command: Sequence[str], output: Path) -> subprocess.Popen[bytes]:
    output.parent.mkdir(parents=True, exist_ok=True)
    with output.open("wb") as file:
        return subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
