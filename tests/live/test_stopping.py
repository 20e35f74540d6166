"""However a run ends or hangs, what it last sends to the motors is stops, and nothing of it is left behind."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sysconfig
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from graphnav import Recording, Status
from tests.live.stages import Trouble

if TYPE_CHECKING:
    from tests.live.conftest import Outside

    Program = Callable[..., Outside]

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
GRAPH = """
plugins: [stages.py]
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  trouble: {use: probe.trouble, in: {image: camera.image}}
  guard: {use: probe.pass, every_ms: 20, in: {command: trouble.twist, image: camera.image}}
outputs: {guard.twist: {channel: BASE, motor: true, max_age_s: 0.5}}
"""
MIN_STOPS = 20
PATIENCE_S = 60.0


class Driven:
    """A run of `GRAPH` in a process of its own, and the process that sends its motor channel."""

    def __init__(self, folder: Path, url: str, program: Outside) -> None:
        graph = folder / "graph.yaml"
        graph.write_text(textwrap.dedent(GRAPH))
        shutil.copy(Path(__file__).with_name("stages.py"), folder)
        self.folder = folder / "run"
        self.program = program
        words = ["run", str(graph), "--url", url, "--no-tap", "--no-pictures", "-o", str(self.folder)]
        with (folder / "output.txt").open("wb") as output:
            self.process = subprocess.Popen([str(GRAPHNAV), *words], stdout=output, stderr=subprocess.STDOUT)
        resource.prlimit(self.process.pid, resource.RLIMIT_CORE, (0, 0))
        self.output = folder / "output.txt"
        self.motors = -1

    def drive(self) -> None:
        """Show pictures until the robot is told to move."""
        n_before = len(self.program.heard)
        end_s = time.monotonic() + PATIENCE_S
        while not any(v > 0 for _, v in self.program.speeds("BASE")[n_before:]):
            assert self.process.poll() is None, self.output.read_text()
            assert time.monotonic() < end_s, "it never drives"
            self.program.show("CAMERA", 100)
            time.sleep(0.05)
        (self.motors,) = _children(self.process.pid)

    def show_until_stopped(self, level: int) -> None:
        """Show pictures of a gray level until the robot is told to stand, and no longer to move."""
        end_s = time.monotonic() + PATIENCE_S
        while not self.is_stopped:
            assert time.monotonic() < end_s, "it is never stopped"
            self.program.show("CAMERA", level)
            time.sleep(0.05)

    @property
    def is_stopped(self) -> bool:
        """Whether the newest commands are stops."""
        newest = self.program.speeds("BASE")[-MIN_STOPS:]
        return len(newest) == MIN_STOPS and all(v == 0.0 for _, v in newest)

    def end(self) -> int:
        """Wait until the run and its motor process have ended; return the run's status."""
        status = self.process.wait(PATIENCE_S)
        end_s = time.monotonic() + PATIENCE_S
        while _is_alive(self.motors):
            assert time.monotonic() < end_s, "the motor process stays"
            time.sleep(0.01)
        assert self.is_stopped
        return status

    def summary(self) -> dict[str, Any]:
        """Return what the run says of itself."""
        summary: dict[str, Any] = json.loads((self.folder / "summary.json").read_text())
        return summary


@pytest.fixture
def driven(tmp_path: Path, group: str, outside: Program) -> Iterator[Driven]:
    """Return a run that tells the robot to move."""
    run = Driven(tmp_path, group, outside("BASE"))
    try:
        run.drive()
        yield run
    finally:
        run.process.kill()
        run.process.wait()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_that_asks_for_the_end_stops_the_robot_and_leaves_a_summary(
    driven: Driven, number: signal.Signals
) -> None:
    driven.process.send_signal(number)
    assert driven.end() == 130
    assert driven.summary()["outcome"] == "stopped"
    with Recording(driven.folder / "run.lcmlog") as log:
        assert log.count("guard.twist") > 0


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV, signal.SIGQUIT])
def test_a_signal_that_ends_the_process_at_once_stops_the_robot(driven: Driven, number: signal.Signals) -> None:
    driven.process.send_signal(number)
    assert driven.end() == -number


def test_a_second_interrupt_stops_the_robot_too(driven: Driven) -> None:
    driven.process.send_signal(signal.SIGINT)
    with contextlib.suppress(subprocess.TimeoutExpired):
        driven.process.wait(0.1)
    driven.process.send_signal(signal.SIGINT)
    assert driven.end() == 130


def test_a_stage_that_raises_stops_the_robot_and_fails_the_run(driven: Driven) -> None:
    driven.show_until_stopped(Trouble.RAISE)
    assert driven.end() == 1
    summary = driven.summary()
    assert summary["outcome"] == "failed"
    assert "told to fail" in summary["failure"]


def test_a_stage_that_hangs_stops_the_robot_and_an_interrupt_still_ends_the_run(driven: Driven) -> None:
    driven.show_until_stopped(Trouble.HANG)
    assert driven.process.poll() is None
    driven.process.send_signal(signal.SIGINT)
    assert driven.end() == 130
    assert driven.summary()["outcome"] == "stopped"


def test_a_stage_that_holds_the_gil_stops_the_robot(driven: Driven) -> None:
    driven.show_until_stopped(Trouble.HOLD_THE_GIL)
    assert driven.process.poll() is None
    driven.process.kill()
    driven.end()


def test_a_run_that_is_suspended_stops_the_robot_and_drives_it_on(driven: Driven) -> None:
    driven.process.send_signal(signal.SIGSTOP)
    driven.show_until_stopped(100)
    driven.process.send_signal(signal.SIGCONT)
    driven.drive()
    driven.process.send_signal(signal.SIGTERM)
    driven.end()


def test_a_motor_process_that_is_suspended_is_reported_and_stops_before_it_drives_on(driven: Driven) -> None:
    os.kill(driven.motors, signal.SIGSTOP)
    driven.show_until_stopped(100)  # by the run itself
    assert f"(pid {driven.motors}) has not taken commands for 0." in driven.output.read_text()
    n_before, resumed_us = len(driven.program.speeds("BASE")), time.time_ns() // 1000
    os.kill(driven.motors, signal.SIGCONT)
    driven.drive()
    after = driven.program.speeds("BASE")[n_before:]
    assert after[0][1] == 0.0
    assert next(utime for utime, v in after if v > 0) >= resumed_us
    assert "commands are taken again, after " in driven.output.read_text()
    driven.process.send_signal(signal.SIGTERM)
    driven.end()
    output = driven.summary()["live"]["outputs"][0]
    assert output["refused"] > 0
    assert not output["fault"]
    with Recording(driven.folder / "run.lcmlog") as log:
        faults = {one.outputs[0]["fault"] for _, _, one in log.messages("graphnav.status") if isinstance(one, Status)}
        decided = [one.v_mps for utime, _, one in log.messages("guard.twist") if utime < resumed_us]  # type: ignore[attr-defined]
    assert decided[-1] == 0.0, "the guard counts commands that are not sent as driven"
    assert max(decided) > 0.0
    assert any(fault.startswith("not taken for ") for fault in faults)


def test_a_run_whose_motor_process_is_suspended_sends_the_stops_at_its_end(driven: Driven) -> None:
    os.kill(driven.motors, signal.SIGSTOP)
    driven.process.send_signal(signal.SIGTERM)
    assert driven.end() == 130
    assert "does not react at the end: the run sends the stops itself" in driven.output.read_text()


def test_a_motor_process_that_dies_fails_the_run(driven: Driven) -> None:
    os.kill(driven.motors, signal.SIGKILL)
    assert driven.process.wait(PATIENCE_S) == 1
    assert "motor channels has died" in driven.summary()["failure"]


def _children(pid: int) -> list[int]:
    """Return the processes that a process has started and that run."""
    running = (int(folder.name) for folder in Path("/proc").iterdir() if folder.name.isdigit())
    return [child for child in running if (fields := _stat(child)) and int(fields[1]) == pid]


def _is_alive(pid: int) -> bool:
    fields = _stat(pid)
    return bool(fields) and fields[0] not in "ZX"


def _stat(pid: int) -> list[str]:
    """Return what the kernel says of a process, beginning with its state and its parent; empty if it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []
