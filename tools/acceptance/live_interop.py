"""Live graphs among other programs: they are driven, overridden and fed by what knows nothing of graphnav's runner."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import graphnav_lcm
import lcm

from acceptance.drives import GRAPHNAV, say
from acceptance.live_override import override_line
from acceptance.processes import await_file, end, graphnav_run, group_url, hear, python, running
from acceptance.rig import Rig
from graphnav import Recording, State
from graphnav.core.record import LOG

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TIMEOUT_S, BRAKES_MPS2, STEP_S = 0.5, 0.5 / 0.25, 0.01
V_MPS = 0.2
FRAMES = 200


def interop_item(seeds: Sequence[int], _jobs: int) -> bool:
    """Drive by pub, teleop and a bare controller; compare a camera's stamps; run the camera driver's example."""
    passed = True
    for number, (name, proof) in enumerate(PROOFS.items(), start=1):
        with tempfile.TemporaryDirectory() as scratch:
            good, numbers = proof(Path(scratch), 200 + number, seeds[1 % len(seeds)])
        passed &= good
        say(f"{'ok  ' if good else 'MISS'} {name}: {numbers}")
    return passed


def pub_line(folder: Path, number: int, seed: int) -> tuple[bool, str]:
    """Drive the robot by ``graphnav pub`` for 3 s; return how far it came and how soon it stood."""
    url = group_url(number)
    robot = graphnav_run("robot_live", url, folder / "robot", "--seed", str(seed), "--set", "robot.state_hz=100")
    with running(robot, folder / "robot.txt"):
        hear(url, "CAMERA")
        pub = [str(GRAPHNAV), "pub", "BASE_CMD", "Twist", f"v_mps: {V_MPS}", "--rate", "10", "--for", "3"]
        subprocess.run([*pub, "--url", url], check=True, stdout=subprocess.DEVNULL)
        time.sleep(2.0)
    with Recording(folder / "robot" / LOG) as log:
        heard_s = [event.utime * 1e-6 for event in log.events() if event.channel == "base.twist"]
        states = [(utime * 1e-6, m) for utime, _, m in log.messages("robot.state") if isinstance(m, State)]
    (_, first), (_, last) = states[0], states[-1]
    driven_m = math.hypot(last.x_m - first.x_m, last.y_m - first.y_m)
    expected_m = V_MPS * (heard_s[-1] - heard_s[0] + TIMEOUT_S)
    stood_s = max(at_s for at_s, m in states if m.v_mps > 0) - heard_s[-1]
    limit_s = TIMEOUT_S + V_MPS / BRAKES_MPS2 + STEP_S
    good = abs(driven_m - expected_m) <= 0.03 * expected_m and stood_s <= limit_s and last.v_mps == 0
    return good, (
        f"{len(heard_s)} commands; the robot drove {driven_m:.3f} m of {expected_m:.3f} m (v times the time from the "
        f"first command to {TIMEOUT_S:g} s after the last), and stood {stood_s:.3f} s after the last "
        f"(allowed {limit_s:.2f} s)"
    )


def bare_line(folder: Path, number: int, seed: int) -> tuple[bool, str]:
    """Let a python-lcm program without graphnav's runner drive the robot to its goal."""
    url = group_url(number)
    robot = graphnav_run("robot_live", url, folder / "robot", "--seed", str(seed), "--until", "150")
    with (
        running(python(HERE.parent / "bare_navigation.py", url), folder / "bare.txt"),
        running(robot, folder / "robot.txt") as process,
    ):
        process.wait(200)
    summary = json.loads((folder / "robot" / "summary.json").read_text())
    return summary["outcome"] == "goal", f"seed {seed} ended with {summary['outcome']} after {summary['sim_s']:.1f} s"


def stamps_line(folder: Path, number: int, _seed: int) -> tuple[bool, str]:
    """Compare the jittered stamps of a camera with those in the log of the graph that saw it."""
    url = group_url(number)
    graph = graphnav_run(HERE / "flow_live.yaml", url, folder / "run")
    with running(graph, folder / "run.txt") as process:
        await_file(folder / "run" / LOG)
        camera = python(HERE / "jittering_camera.py", url, str(FRAMES))
        done = subprocess.run(camera, check=True, capture_output=True, text=True)
        time.sleep(1.0)
        end(process)
    sent: list[int] = json.loads(done.stdout)
    summary = json.loads((folder / "run" / "summary.json").read_text())
    overtaken = sum(edge["overtaken"] for edge in summary["live"]["edges"])
    with Recording(folder / "run" / LOG) as log:
        seen, flows = log.utimes("camera.image"), log.utimes("flow.flow")
    intervals_ms = [(later - earlier) / 1e3 for earlier, later in pairwise(sent)]
    accepted = summary["live"]["inputs"][0]["accepted"]
    kept, flowed = set(seen), set(flows)
    good = (
        len(seen) > FRAMES // 2
        and seen == [utime for utime in sent if utime in kept]
        and flows == [utime for utime in sent if utime in flowed]
        and len(flows) == accepted - 1 - overtaken
    )
    return good, (
        f"{accepted} of {FRAMES} frames came, {min(intervals_ms):.1f} to {max(intervals_ms):.1f} ms apart, {overtaken} "
        f"were overtaken; {len(kept & set(sent))} of {len(seen)} frames in the log have the camera's stamps, and "
        f"{len(flowed & set(sent))} of {len(flows)} flows"
    )


def example_line(folder: Path, _number: int, _seed: int) -> tuple[bool, str]:
    """Run the commands of the camera driver's example; return what its C receiver printed."""
    test = "tests/docs/test_camera_driver.py::test_the_commands_drive_the_wheels_and_stop_them"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--basetemp", str(folder / "test"), test]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode or not (printed := [*folder.rglob("wheels.txt")]):
        return False, done.stdout[-500:]
    lines = printed[0].read_text().splitlines()[1:]
    turning = [line for line in lines if any(digit in line for digit in "123456789")]
    return bool(turning), (
        f"the C receiver printed {len(lines)} lines, {len(turning)} with turning wheels: first "
        f"'{lines[0]}', midway '{turning[len(turning) // 2]}', at last '{lines[-1]}'"
    )


def c_camera_line(folder: Path, number: int, seed: int) -> tuple[bool, str]:
    """Let a camera in C, which leaves step_px and seq of a zeroed struct at 0, show what the robot sees."""
    example = Path(shutil.copytree(ROOT / "docs" / "examples" / "camera_driver", folder / "example"))
    path = f"{GRAPHNAV.parent}{os.pathsep}{os.environ['PATH']}"
    make = ["make", "-B", "-C", str(example), f"PYTHON={sys.executable}", "camera"]
    subprocess.run(make, check=True, stdout=subprocess.DEVNULL, env={**os.environ, "PATH": path})
    with Rig(folder, number, seed) as rig:
        rig.kill_camera()
        url = {**os.environ, "LCM_DEFAULT_URL": rig.graph_url}
        camera = subprocess.Popen([str(example / "camera"), "160", "120"], stdin=subprocess.PIPE, env=url)
        assert camera.stdin is not None
        eye, pictures = lcm.LCM(rig.robot_url), camera.stdin

        def show(_channel: str, data: bytes) -> None:
            pictures.write(graphnav_lcm.image_t.decode(data).data)
            pictures.flush()

        eye.subscribe("CAMERA", show)
        rig.navigate()
        while rig.is_driving:
            eye.handle_timeout(100)
        pictures.close()
        camera.wait(10)
        robot, navigation = rig.finish()
    (heard,) = (one for one in navigation["live"]["inputs"] if one["channel"] == "CAMERA")
    good = robot["outcome"] == "goal" and not heard["rejected"]
    return good, (
        f"seed {seed} ended with {robot['outcome']} after {robot['sim_s']:.1f} s; {heard['accepted']} pictures were "
        f"used, rejected {dict(zip(heard['reasons'], heard['rejected'], strict=True))}"
    )


PROOFS = {
    "graphnav pub drives the robot": pub_line,
    "teleop overrides the graph": override_line,
    "a bare python-lcm controller drives the robot": bare_line,
    "a camera whose stamps jitter": stamps_line,
    "the camera driver's example": example_line,
    "a camera in C with a zeroed struct": c_camera_line,
}
