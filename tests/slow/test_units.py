"""A unit of ``graphnav deploy`` under systemd itself, in namespaces of its own: hung, killed, stopped."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphnav.core.cli import main
from tests.live.conftest import STAGES, Outside, outside  # noqa: F401 - a fixture
from tests.targets import Targets

SYSTEMD = Path("/lib/systemd/systemd")
UNIT = "graphnav-robot.service"
GRAPH = """
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  see: {use: probe.brightness, in: {image: camera.image}}
  guard: {use: probe.pass, every_ms: 20, in: {command: see.twist, image: camera.image}}
outputs: {guard.twist: {channel: SPEED, motor: true}}
"""
BOOT = f"""
mount -t tmpfs tmpfs /run && mount -t cgroup2 none /sys/fs/cgroup || exit 9
mkdir -p /run/systemd/system/{UNIT}.d
cp "$1/{UNIT}" /run/systemd/system/
printf '[Unit]\\nDefaultDependencies=no\\nAfter=\\nWants=\\n' > /run/systemd/system/{UNIT}.d/alone.conf
printf '[Unit]\\nDefaultDependencies=no\\nWants={UNIT}\\n' > /run/systemd/system/alone.target
export container=other
exec {SYSTEMD} --unit=alone.target --log-target=console --default-standard-output=inherit
"""
WATCHDOG_S = 2
MIN_STOPS = 20
"""Of the fifty that the motor process sends after the run has died."""
PATIENCE_S = 60.0

pytestmark = pytest.mark.skipif(
    os.getuid() != 0 or not SYSTEMD.exists() or shutil.which("unshare") is None, reason="needs root and systemd"
)


class Machine:
    """A systemd that runs one unit."""

    def __init__(self, units: Path, printed: Path) -> None:
        with printed.open("wb") as out:
            command = ["unshare", "-fpm", "--mount-proc", "--kill-child", "bash", "-c", BOOT, "boot", str(units)]
            self._process = subprocess.Popen(command, stdout=out, stderr=out)

    def main_pid(self) -> int:
        """Return the process of the run, as this machine numbers it; 0 while there is none."""
        found = [pid for pid in _children(self._init()) if b"\0run\0" in _command(pid)]
        return found[0] if found else 0

    def pids(self) -> set[int]:
        """Return the processes of the unit, as this machine numbers them."""
        found, pending = set[int](), _children(self._init())
        while pending:
            found.add(pid := pending.pop())
            pending += _children(pid)
        return found

    def ask(self, *words: str) -> str:
        """Return what ``systemctl`` says."""
        enter = ["nsenter", "-t", str(self._init()), "-m", "-p", "systemctl", *words]
        return subprocess.run(enter, capture_output=True, text=True, check=False).stdout.strip()

    def close(self) -> None:
        """End it and all that it runs."""
        self._process.kill()
        self._process.wait()

    def _init(self) -> int:
        return next(iter(_children(self._process.pid)), 0)


def _children(pid: int) -> list[int]:
    try:
        return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def wait_for(holds: Callable[[], object]) -> float:
    """Wait until something holds; return how long it took, s."""
    begin_s = time.monotonic()
    while not holds():
        assert time.monotonic() - begin_s < PATIENCE_S, "it never came"
        time.sleep(0.02)
    return time.monotonic() - begin_s


@pytest.fixture
def base(outside: Callable[..., Outside]) -> Iterator[Outside]:  # noqa: F811 - the fixture
    """Return the robot's base, in front of which a camera shows a picture 20 times a second."""
    made, ending = outside("SPEED"), threading.Event()

    def show() -> None:
        while not ending.wait(0.05):
            made.show("CAMERA", 7)

    camera = threading.Thread(target=show)
    camera.start()
    yield made
    ending.set()
    camera.join()


@pytest.fixture(params=["one process", "processes"])
def machine(
    request: pytest.FixtureRequest, tmp_path: Path, group: str, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Machine]:
    """Return a machine on which the unit has been started."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LCM_DEFAULT_URL", group)
    (tmp_path / "robot.yaml").write_text(GRAPH)
    options = ("--plugin", str(STAGES), "--to", "systemd", "--watchdog-s", str(WATCHDOG_S))
    apart = ["--processes"] if request.param == "processes" else []
    assert main(["deploy", "robot.yaml", *options, *apart]) == 0
    made = Machine(tmp_path / "units", tmp_path / "printed.txt")
    yield made
    made.close()
    sys.stdout.write((tmp_path / "printed.txt").read_text())


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL])
def test_a_run_that_hangs_or_dies_is_started_again(
    targets: Targets, machine: Machine, base: Outside, number: signal.Signals
) -> None:
    """From the harm to the first stop, and to the next command that moves."""
    wait_for(lambda: [v for _, v in base.speeds("SPEED")][-3:] == [7.0] * 3)
    wait_for(lambda: machine.ask("is-active", UNIT) == "active")
    before, others = machine.main_pid(), machine.pids()
    os.kill(before, number)
    stop_s = wait_for(lambda: base.speeds("SPEED")[-1][1] == 0.0)
    again_s = stop_s + wait_for(lambda: base.speeds("SPEED")[-1][1] == 7.0)
    assert machine.main_pid() not in (0, before)
    assert not others & machine.pids(), "a process of the former run is left"
    stops = sum(v == 0.0 for _, v in base.speeds("SPEED"))
    targets.check(
        f"{number.name}: stop after {stop_s:.2f} s, {stops} stops; drives after {again_s:.1f} s", good=stops > MIN_STOPS
    )
    assert machine.ask("show", "-P", "NRestarts", UNIT) == "1"


def test_a_stop_ends_the_run_in_good_order(machine: Machine, base: Outside, tmp_path: Path) -> None:
    """Stops, a summary, and a unit that has not failed."""
    wait_for(lambda: [v for _, v in base.speeds("SPEED")][-3:] == [7.0] * 3)
    wait_for(lambda: "no fault" in machine.ask("show", "-P", "StatusText", UNIT))
    machine.ask("stop", UNIT)
    assert (machine.ask("show", "-P", "ActiveState", UNIT), machine.ask("show", "-P", "Result", UNIT)) == (
        "inactive",
        "success",
    )
    assert base.speeds("SPEED")[-1][1] == 0.0
    assert not machine.pids()
    assert [path.name for path in (tmp_path / "runs").glob("*/summary.json")] == ["summary.json"]
