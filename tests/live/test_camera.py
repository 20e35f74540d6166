"""A camera in a live run: it fires by its pictures, holds nothing up, and the guard sees when they cease or freeze."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import cv2
import numpy as np
import pytest

from graphnav import GuardState, UserError
from graphnav.core.cli import main
from graphnav.core.codec import decode
from graphnav.core.graph import Graph

from .conftest import PATIENCE_S, Live, Outside

MOVES = """
run: {{until_s: 40, record: all}}
stages:
  camera: {{use: io.camera, with: {{device: {device}, gray: true}}}}
  go:     {{use: probe.trouble, in: {{image: camera.image}}}}
  {more}
  guard:
    use: control.guard
    every_ms: 20
    with: {{max_age_s: {max_age_s}, min_judged_ratio: 0, min_contrast_gray: 0}}
    in: {{command: go.twist, image: camera.image{wires}}}
outputs:
  guard.twist: {{channel: SPEED, type: graphnav_lcm.twist_t, motor: true}}
  guard.state: {{channel: STATE}}
"""


def graph_of(device: Path, more: str = "", wires: str = "", max_age_s: float = 0.5) -> str:
    return MOVES.format(device=device, more=more, wires=wires, max_age_s=max_age_s)


def video(path: Path, count: int) -> Path:
    """Write pictures that are all the same, 20 a second."""
    picture = np.random.default_rng(0).integers(0, 180, (120, 160), np.uint8)
    picture = cv2.cvtColor(cv2.GaussianBlur(picture, (0, 0), 2), cv2.COLOR_GRAY2BGR)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (160, 120))
    for _ in range(count):
        writer.write(picture)
    writer.release()
    return path


def moves(program: Outside) -> bool:
    return any(v > 0 for _, v in program.speeds("SPEED"))


def test_the_base_stops_when_a_camera_ends(
    live: Callable[..., Live], outside: Callable[..., Outside], tmp_path: Path
) -> None:
    program = outside("SPEED")
    run = live(graph_of(video(tmp_path / "clip.avi", 30)))
    program.wait_for(lambda: moves(program))
    summary, recording = run.finish()
    program.wait_for(lambda: program.speeds("SPEED")[-1][1] == 0.0)
    assert summary.outcome == "end"
    assert run.notices[0] == (
        f"camera: '{tmp_path}/clip.avi' gives 160x120 at 20 Hz; pictures are stamped by the time of arrival"
    )
    assert f"camera: ended: '{tmp_path}/clip.avi' has no picture left" in run.notices
    with recording:
        stamps = [utime for _, utime, _ in recording.messages("camera.image")]
        assert stamps == [utime for _, utime, _ in recording.messages("go.twist")][: len(stamps)] == sorted(set(stamps))
    assert summary.scores["camera"]["pictures"] == len(stamps)


def test_a_camera_that_stalls_stops_the_base_and_not_the_run(
    live: Callable[..., Live], outside: Callable[..., Outside], tmp_path: Path
) -> None:
    data, pipe = video(tmp_path / "clip.avi", 1000).read_bytes(), tmp_path / "pipe"
    stalls, goes_on = threading.Event(), threading.Event()
    os.mkfifo(pipe)

    def write() -> None:
        with suppress(BrokenPipeError), pipe.open("wb", buffering=0) as file:
            for begin in range(0, len(data), 4000):
                if stalls.is_set():
                    goes_on.wait(PATIENCE_S)
                file.write(data[begin : begin + 4000])
                time.sleep(0.02)

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    program = outside("SPEED")
    run = live(graph_of(pipe))
    program.wait_for(lambda: moves(program))
    stalls.set()
    program.wait_for(lambda: program.speeds("SPEED")[-1][1] == 0.0)
    stopped = len(program.speeds("SPEED"))
    program.wait_for(lambda: len(program.speeds("SPEED")) > stopped + 20)  # the guard goes on
    program.wait_for(lambda: any("has had nothing from its device for" in one for one in run.notices))
    goes_on.set()
    program.wait_for(lambda: any(v > 0 for _, v in program.speeds("SPEED")[stopped + 20 :]))
    _, recording = run.stop()
    writer.join(PATIENCE_S)
    with recording:
        states = [state for _, _, state in recording.messages("guard.state") if isinstance(state, GuardState)]
        causes = {cause for state in states for cause in state.causes}
    assert "stale" in causes


def test_a_camera_that_repeats_its_picture_is_noticed(
    live: Callable[..., Live], outside: Callable[..., Outside], tmp_path: Path
) -> None:
    program = outside("STATE")
    flow = "flow:   {use: flow.lucas_kanade, in: {image: camera.image}}"
    live(graph_of(video(tmp_path / "clip.avi", 1000), flow, ", flow: flow.flow", max_age_s=5.0))
    program.wait_for(lambda: any("frozen" in decode(GuardState, data)[2].causes for data in program.of("STATE")[-20:]))


@pytest.mark.parametrize(
    ("more", "what"),
    [
        (
            "deploy: {eye: {stages: [camera]}}",
            "the process 'eye' names stage 'camera' (io.camera), which takes what a device",
        ),
        ("both: {use: probe.both, in: {a: go.twist, b: other.twist}}", "joins a simulated source with a device"),
    ],
)
def test_what_a_graph_with_a_camera_cannot_have_is_refused(
    more: str, what: str, load: Callable[[str], Graph], tmp_path: Path
) -> None:
    world = (
        "world: {use: world.robot, in: {command: go.twist}}\n  other: {use: probe.trouble, in: {image: world.image}}"
    )
    text = graph_of(tmp_path, world if "both" in more else "")
    text = text.replace("\n  guard:", f"\n  {more}\n  guard:") if "both" in more else text + more
    with pytest.raises(UserError, match=what.replace("(", r"\(").replace(")", r"\)")):
        load(text)


def test_with_processes_a_camera_stays_in_that_of_the_run(load: Callable[[str], Graph], tmp_path: Path) -> None:
    graph = load(graph_of(tmp_path))
    assert graph.is_live
    assert graph.arriving == ("camera",)
    assert set(graph.with_processes().deploy) == {"go", "guard"}


def test_a_study_with_a_camera_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(
            [
                "ablate",
                "camera_flow",
                "--set",
                f"camera.device={tmp_path}",
                "--vary",
                "plane=plane.affine",
                "--seeds",
                "0:2",
            ]
        )
        == 2
    )
    assert "stage 'camera' (io.camera) takes what a device delivers, but a study runs in simulated time" in (
        capsys.readouterr().err
    )
