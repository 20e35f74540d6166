"""Two network namespaces joined by a cable: ``graphnav spy`` in one sees a run in the other, whose tap has ttl=0."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import running

GROUP = "udpm://239.255.76.67:7667"
PATIENCE_S = 90.0


def ip(*words: str) -> None:
    """Run ip."""
    subprocess.run(["ip", *words], check=True, capture_output=True)


@pytest.fixture
def networks() -> Iterator[tuple[str, str]]:
    """Return two network namespaces, 10.99.0.1 and 10.99.0.2, which also have multicast inside."""
    names = f"gn-robot-{os.getpid()}", f"gn-laptop-{os.getpid()}"
    cables = f"gnr{os.getpid()}", f"gnl{os.getpid()}"
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and ip")
    with ExitStack() as cleanup:
        for name in names:
            try:
                ip("netns", "add", name)
            except subprocess.CalledProcessError as error:
                pytest.skip(f"no network namespaces: {error.stderr.decode().strip()}")
            cleanup.callback(ip, "netns", "del", name)
        ip("link", "add", cables[0], "type", "veth", "peer", "name", cables[1])
        for k, (name, cable) in enumerate(zip(names, cables, strict=True), 1):
            ip("link", "set", cable, "netns", name)
            ip("-n", name, "addr", "add", f"10.99.0.{k}/24", "dev", cable)
            ip("-n", name, "link", "set", cable, "up")
            ip("-n", name, "link", "set", "lo", "up", "multicast", "on")
            ip("-n", name, "route", "add", "224.0.0.0/4", "dev", "lo")
        yield names


def command(network: str, *words: str) -> list[str]:
    """Return a command of graphnav in a network namespace."""
    return ["ip", "netns", "exec", network, str(GRAPHNAV), *words]


def await_text(path: Path, text: str) -> None:
    """Wait until a program has printed something."""
    end_s = time.monotonic() + PATIENCE_S
    while text not in path.read_text():
        assert time.monotonic() < end_s, path.read_text()
        time.sleep(0.05)


def output_of(words: Sequence[str], environment: dict[str, str]) -> str:
    """Return what a command prints."""
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


@pytest.mark.long
def test_spy_on_the_laptop_sees_the_run_on_the_robot(
    networks: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, laptop = networks
    monkeypatch.setenv("LCM_DEFAULT_URL", GROUP)
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    key, served, called = tmp_path / "key", tmp_path / "served.txt", tmp_path / "called.txt"
    environment = dict(os.environ)
    with ExitStack() as ends:
        ends.enter_context(running(command(robot, "tunnel", "--serve", "--key", str(key)), served))
        await_text(served, "serving udpm://239.255.76.67:7667 on port 7668")
        run = ["run", "corridor_ccw", "--pace", "1", "--until", "600", "--no-pictures", "-o", str(tmp_path / "run")]
        ends.enter_context(running(command(robot, *run), tmp_path / "run.txt"))
        spy = command(laptop, "spy", "--once", "--for", "2", "--json")
        assert "no message on udpm://239.255.76.67:7667" in output_of(spy, environment)  # ttl=0, and two networks
        ends.enter_context(running(command(laptop, "tunnel", "10.99.0.1", "--key", str(key)), called))
        await_text(called, "connected to 10.99.0.1:7668")
        await_text(served, "connected to 10.99.0.2:")
        end_s = time.monotonic() + PATIENCE_S
        while '"steer.steering"' not in (seen := output_of(spy, environment)):  # until the run has begun
            assert time.monotonic() < end_s, seen
        top = output_of(command(laptop, "top", "--once"), environment)
        assert "corridor_ccw" in top
    assert "steer.steering" in called.read_text()  # in its table
