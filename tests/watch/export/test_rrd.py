"""A recording for Rerun passes Rerun's own check and holds what the log holds, and nothing is sent over the network."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sysconfig
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

from graphnav import Odometry, Scan, Twist
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter, Recording

SCRIPTS = Path(sysconfig.get_path("scripts"))


def rerun(home: Path, *words: object) -> str:
    """Return what Rerun's command line says, which has to be content."""
    environment = {**os.environ, "HOME": str(home), "XDG_CONFIG_HOME": str(home), "CI": "true", "NO_COLOR": "1"}
    done = subprocess.run(
        [SCRIPTS / "rerun", *map(str, words)], capture_output=True, text=True, check=False, env=environment, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def rows(home: Path, path: Path) -> dict[str, int]:
    """Return the number of rows of each entity of a recording, its blueprint left out."""
    found: dict[str, int] = {}
    for line in rerun(home, "rrd", "print", path).splitlines():
        if told := re.match(r"Chunk\(\S+\) with (\S+) rows .* - (/.*?) - ", line):
            found[told[2]] = found.get(told[2], 0) + int(told[1].replace("\N{THIN SPACE}", ""))
    return found


@pytest.fixture(scope="module")
def exported(drive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the recording of the drive."""
    target = tmp_path_factory.mktemp("rrd") / "drive.rrd"
    assert main(["export", str(drive), "--to", "rrd", "-o", str(target)]) == 0
    return target


def test_rerun_accepts_it(exported: Path, tmp_path: Path) -> None:
    assert "verified without error" in rerun(tmp_path, "rrd", "verify", exported)


def test_every_message_is_there(exported: Path, drive: Path, tmp_path: Path) -> None:
    found = rows(tmp_path, exported)
    with Recording(drive / "run.lcmlog") as recording:
        for entity, channel in (
            ("/control/twist/v_mps", "control.twist"),
            ("/steer/steering/theta_rad", "steer.steering"),
            (r"/steer/steering/control\[1\]", "steer.steering"),
            ("/robot/image/picture", "robot.image"),
            ("/plane/plane/picture", "plane.plane"),
            ("/scene/robot", "robot.state"),
        ):
            assert found[entity] == recording.count(channel), entity
    assert found["/log"] == 2
    assert not any(entity.endswith(("/utime", "/seq")) for entity in found)


def test_a_blueprint_opens_the_views(exported: Path, tmp_path: Path) -> None:
    said = rerun(tmp_path, "rrd", "print", exported)
    assert "Blueprint" in said
    assert said.count("/view/") >= 9


def test_names_and_numbers_of_any_program_are_survived(tmp_path: Path) -> None:
    names = ["a/b", "..", "x\x1b[31m", "\N{SNOWMAN} [x]", "scene.map", "log"]
    with LogWriter(tmp_path / "log") as log:
        for name in names:
            log.write(name, 5, encode(Twist(v_mps=math.nan, omega_radps=-math.inf), 5, 0))
        log.write("POSE", 6, encode(Odometry(1.0, 2.0, 0.0, 0.0, math.inf), 6, 0))
        log.write("POSE", 7, encode(Odometry(math.nan, 2.0, 0.0, 0.0, 0.0), 7, 1))
    for kind in ("rrd", "mcap"):
        assert main(["export", str(tmp_path / "log"), "--to", kind, "-o", str(tmp_path / kind)]) == 0
    assert "verified without error" in rerun(tmp_path, "rrd", "verify", tmp_path / "rrd")
    assert rows(tmp_path, tmp_path / "rrd")["/scene/robot"] == 1


def test_a_scan_moves_with_the_robot(tmp_path: Path) -> None:
    scan = Scan(-0.5, 0.5, 0.1, 10.0, np.array([1.0, math.inf, 2.5], np.float32))
    with LogWriter(tmp_path / "log") as log:
        log.write("robot.scan", 5, encode(scan, 5, 0))
    assert main(["export", str(tmp_path / "log"), "--to", "rrd", "-o", str(tmp_path / "rrd")]) == 0
    assert "verified without error" in rerun(tmp_path, "rrd", "verify", tmp_path / "rrd")
    assert rows(tmp_path, tmp_path / "rrd")["/scene/robot/robot/scan"] == 1


def test_nothing_is_sent_over_the_network(drive: Path, tmp_path: Path) -> None:
    """Rerun's analytics begin with a file in the user's configuration; an export makes none."""
    environment = {name: value for name, value in os.environ.items() if name != "CI"}
    environment |= {name: str(tmp_path / "home") for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME")}
    environment["MPLCONFIGDIR"] = mpl.get_cachedir()  # a slow machine says that it makes a cache of fonts
    words = [SCRIPTS / "graphnav", "export", drive, "--to", "rrd", "-o", tmp_path / "a.rrd", "--until", "0.5s"]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=True, env=environment)
    assert done.stderr == ""
    assert not list((tmp_path / "home").rglob("*rerun*"))
    assert not list((tmp_path / "home").rglob("*analytics*"))
