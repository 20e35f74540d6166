"""``graphnav teach`` beside a robot in another process: it ends by itself, by Ctrl-C, or with a true hint."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from graphnav import Odometry, PlanarModel, Recording, Twist
from graphnav.core.cli import main
from tests.forked_commands import forked_graphnav

if TYPE_CHECKING:
    from tests.live.conftest import Outside

ROBOT = """
run: {seed: 3, record: small}
outputs:
  robot.image:    {channel: CAMERA}
  robot.odometry: {channel: ODOMETRY}
stages:
  robot:  {use: world.robot, with: {map: maps/empty.yaml, image_hz: 20}, in: {command: driver.twist}}
  driver: {use: control.wander, with: {leg_s: 0.4, straight_ratio: 0.0}, in: {image: robot.image}}
"""
TEACH = ["teach", "teach_live", "--set", "teach.terms=[v,w]"]
PATIENCE_S = 60


@pytest.fixture
def robot(tmp_path: Path, group: str) -> Iterator[None]:
    """Run a robot that drives at random, in a process of its own."""
    graph = tmp_path / "robot.yaml"
    graph.write_text(ROBOT)
    words = ["run", str(graph), "--live", "--url", group, "--no-tap", "--no-pictures", "-o", str(tmp_path / "robot")]
    with (tmp_path / "robot.txt").open("wb") as output:
        process = subprocess.Popen([str(forked_graphnav()), *words], stdout=output, stderr=subprocess.STDOUT)
    yield
    process.send_signal(signal.SIGINT)
    process.wait(PATIENCE_S)


def taught(path: Path) -> PlanarModel:
    """Return the model in a file, which holds nothing else."""
    with Recording(path) as log:
        assert log.n_events == 1
        model = log.message("teach.planar_model", 0)[2]
    assert isinstance(model, PlanarModel)
    return model


@pytest.mark.usefixtures("robot")
def test_it_ends_once_the_motions_asked_for_are_taught(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.lcmlog"
    words = ["--until-taught", "0.15,0.4", "--until", str(2 * PATIENCE_S), "--url", group, "-o", str(path)]
    assert main([*TEACH, *words]) == 0
    printed = capsys.readouterr()
    assert f"teaching live on {group}" in printed.err
    assert " until 0.15 m/s and 0.4 rad/s are taught or 120 s or Ctrl-C\n" in printed.err
    assert printed.out.startswith(f"{path}: v, w on 40 x 30 cells of 4 px, from ")
    model = taught(path)
    period_s = model.interval_us * 1e-6
    # the ranges are of displacements over the intervals of all frames, some of which are longer
    assert model.forward_range_m[1] >= 0.9 * 0.15 * period_s
    assert model.turn_range_rad[0] <= -0.9 * 0.4 * period_s
    assert model.turn_range_rad[1] >= 0.9 * 0.4 * period_s


@pytest.mark.usefixtures("robot")
def test_ctrl_c_saves_the_newest_model(tmp_path: Path, group: str) -> None:
    path, scratch = tmp_path / "model.lcmlog", tmp_path / "scratch"
    scratch.mkdir()
    command = [str(forked_graphnav()), *TEACH, "--set", "teach.every_frames=5", "--url", group, "-o", str(path)]
    pipe, env = subprocess.PIPE, os.environ | {"TMPDIR": str(scratch)}
    teaching = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=env)
    end_s = time.monotonic() + PATIENCE_S
    while teaching.poll() is None and time.monotonic() < end_s and not has_model(scratch):
        time.sleep(0.02)
    teaching.send_signal(signal.SIGINT)
    printed, errors = teaching.communicate(timeout=PATIENCE_S)
    assert teaching.returncode == 0, errors
    assert printed.startswith(f"{path}: v, w on 40 x 30 cells of 4 px, from {taught(path).frames} frames")
    assert list(scratch.iterdir()) == []


def has_model(scratch: Path) -> bool:
    """Return whether the log of what is taught has a model: it is far larger than anything else in it."""
    return any(log.stat().st_size > 20_000 for log in scratch.glob("*/run.lcmlog"))


@contextmanager
def sending(program: Outside, send: Callable[[Outside], object]) -> Iterator[None]:
    """Send again and again, meanwhile."""
    ending = threading.Event()

    def work() -> None:
        while not ending.wait(0.02):
            send(program)

    thread = threading.Thread(target=work)
    thread.start()
    yield
    ending.set()
    thread.join()


def refused(tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the hint of a second of teaching that finds nothing."""
    assert main([*TEACH, "--until", "1", "--url", group, "-o", str(tmp_path / "model.lcmlog")]) == 2
    errors = capsys.readouterr().err
    assert not list(tmp_path.glob("model.lcmlog"))
    assert "did not publish a planar model\n  " in errors
    return errors.rpartition("did not publish a planar model\n  ")[2].strip()


def test_a_silent_camera_is_named(tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert refused(tmp_path, group, capsys) == "no message on CAMERA: start its sender, or give its URL with --url"


def test_a_camera_of_another_type_is_named(
    tmp_path: Path, group: str, outside: Callable[..., Outside], capsys: pytest.CaptureFixture[str]
) -> None:
    with sending(outside(), lambda program: program.say("CAMERA", Twist(v_mps=0.0, omega_radps=0.0))):
        hint = refused(tmp_path, group, capsys)
    assert hint.startswith("no message on CAMERA could be used: ")
    assert " wrong type" in hint
    assert hint.endswith("; correct its sender")


def test_odometry_by_another_clock_is_named(
    tmp_path: Path, group: str, outside: Callable[..., Outside], capsys: pytest.CaptureFixture[str]
) -> None:
    ahead_us = 3_600_000_000

    def send(program: Outside) -> None:
        program.show("CAMERA", 0)
        still = Odometry(x_m=0.0, y_m=0.0, yaw_rad=0.0, v_mps=0.0, omega_radps=0.0)
        program.say("ODOMETRY", still, time.time_ns() // 1000 + ahead_us)

    with sending(outside(), send):
        hint = refused(tmp_path, group, capsys)
    assert hint == "no motion of a frame is known: give odometry whose stamps cover those of the pictures"
