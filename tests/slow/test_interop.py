"""Live graphs among other programs: they are driven, overridden and fed by what knows nothing of graphnav's runner."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import graphnav_lcm
import lcm
import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import await_file, end, graphnav_run, group_url, hear, python, running
from testbed.rig import Rig

from graphnav import Recording, State
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TIMEOUT_S, BRAKES_MPS2, STEP_S = 0.5, 0.5 / 0.25, 0.01
V_MPS = 0.2
FRAMES = 200


@pytest.fixture(scope="module")
def seed(seeds: range) -> int:
    """Return the seed of the drives."""
    return seeds[1 % len(seeds)]


def test_interop_pub_drives_the_robot(targets: Targets, tmp_path: Path, seed: int) -> None:
    """By ``graphnav pub`` for 3 s: how far it comes and how soon it stands."""
    url, folder = group_url(201), tmp_path
    robot = graphnav_run("robot_live", url, folder / "robot", "--seed", str(seed), "--set", "robot.state_hz=100")
    with running(robot, folder / "robot.txt"):
        hear(url, "CAMERA")
        pub = [str(GRAPHNAV), "pub", "BASE_CMD", "Twist", f"v_mps: {V_MPS}", "--rate", "10", "--for", "3"]
        subprocess.run([*pub, "--url", url], check=True, stdout=subprocess.DEVNULL)
        time.sleep(2.0)
    with Recording(folder / "robot" / RunFolder.LOG) as log:
        heard_s = [event.utime * 1e-6 for event in log.events() if event.channel == "base.twist"]
        states = [(utime * 1e-6, m) for utime, _, m in log.messages("robot.state") if isinstance(m, State)]
    (_, first), (_, last) = states[0], states[-1]
    driven_m = math.hypot(last.x_m - first.x_m, last.y_m - first.y_m)
    expected_m = V_MPS * (heard_s[-1] - heard_s[0] + TIMEOUT_S)
    stood_s = max(at_s for at_s, m in states if m.v_mps > 0) - heard_s[-1]
    limit_s = TIMEOUT_S + V_MPS / BRAKES_MPS2 + STEP_S
    good = abs(driven_m - expected_m) <= 0.03 * expected_m and stood_s <= limit_s and last.v_mps == 0
    targets.check(
        f"{len(heard_s)} commands; the robot drove {driven_m:.3f} m of {expected_m:.3f} m (v times the time from the "
        f"first command to {TIMEOUT_S:g} s after the last), and stood {stood_s:.3f} s after the last "
        f"(allowed {limit_s:.2f} s)",
        good=good,
    )


def test_interop_a_bare_controller_drives_the_robot(targets: Targets, tmp_path: Path, seed: int) -> None:
    """A python-lcm program without graphnav's runner drives it to its goal."""
    url, folder = group_url(203), tmp_path
    robot = graphnav_run("robot_live", url, folder / "robot", "--seed", str(seed), "--until", "150")
    with (
        running(python(ROOT / "tools" / "bare_navigation.py", url), folder / "bare.txt"),
        running(robot, folder / "robot.txt") as process,
    ):
        process.wait(200)
    summary = json.loads((folder / "robot" / "summary.json").read_text())
    text = f"seed {seed} ended with {summary['outcome']} after {summary['sim_s']:.1f} s"
    targets.check(text, good=summary["outcome"] == "goal")


def test_interop_stamps_of_a_camera_that_jitters(targets: Targets, tmp_path: Path) -> None:
    """The jittered stamps of a camera are those in the log of the graph that saw it."""
    url, folder = group_url(204), tmp_path
    graph = graphnav_run(HERE / "flow_live.yaml", url, folder / "run")
    with running(graph, folder / "run.txt") as process:
        await_file(folder / "run" / RunFolder.LOG)
        camera = python(HERE / "jittering_camera.py", url, str(FRAMES))
        done = subprocess.run(camera, check=True, capture_output=True, text=True)
        time.sleep(1.0)
        end(process)
    sent: list[int] = json.loads(done.stdout)
    summary = json.loads((folder / "run" / "summary.json").read_text())
    overtaken = sum(edge["overtaken"] for edge in summary["live"]["edges"])
    with Recording(folder / "run" / RunFolder.LOG) as log:
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
    targets.check(
        f"{accepted} of {FRAMES} frames came, {min(intervals_ms):.1f} to {max(intervals_ms):.1f} ms apart, {overtaken} "
        f"were overtaken; {len(kept & set(sent))} of {len(seen)} frames in the log have the camera's stamps, and "
        f"{len(flowed & set(sent))} of {len(flows)} flows",
        good=good,
    )


def test_interop_a_camera_in_c_with_a_zeroed_struct(targets: Targets, tmp_path: Path, seed: int) -> None:
    """A camera in C, which leaves step_px and seq of a zeroed struct at 0, shows what the robot sees."""
    folder = tmp_path
    example = Path(shutil.copytree(ROOT / "docs" / "examples" / "camera_driver", folder / "example"))
    path = f"{GRAPHNAV.parent}{os.pathsep}{os.environ['PATH']}"
    make = ["make", "-B", "-C", str(example), f"PYTHON={sys.executable}", "camera"]
    subprocess.run(make, check=True, stdout=subprocess.DEVNULL, env={**os.environ, "PATH": path})
    with Rig(folder, 206, seed) as rig:
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
    targets.check(
        f"seed {seed} ended with {robot['outcome']} after {robot['sim_s']:.1f} s; {heard['accepted']} pictures were "
        f"used, rejected {dict(zip(heard['reasons'], heard['rejected'], strict=True))}",
        good=good,
    )
