"""A live run tells systemd that it is ready, that its engine turns, its faults and its end."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphnav.live.health.service_manager import ServiceManager
from tests.live.conftest import PATIENCE_S, Live, Outside

GRAPH = """
run: {until_s: 60}
inputs: {camera.image: {channel: CAMERA, type: graphnav_lcm.image_t}}
stages:
  see: {use: probe.brightness, in: {image: camera.image}, with: {dawdle_s: %s}}
outputs: {see.twist: {channel: SPEED, motor: false}}
"""
PERIOD_S = 0.2


class Manager:
    """The other side of a socket as systemd gives it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.heard: list[str] = []
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._socket.setblocking(False)

    def read(self) -> list[str]:
        """Return all that was heard."""
        try:
            while True:
                self.heard.append(self._socket.recv(4096).decode())
        except BlockingIOError:
            return self.heard

    def wait_for(self, line: str, more: int = 1) -> None:
        """Wait until a line was heard so many times more."""
        wanted = self.read().count(line) + more
        end_s = time.monotonic() + PATIENCE_S
        while self.read().count(line) < wanted:
            assert time.monotonic() < end_s, f"{line} never came: {self.heard}"
            time.sleep(0.005)

    def close(self) -> None:
        """Leave."""
        self._socket.close()


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Manager]:
    """Return a service manager that waits for this process."""
    made = Manager(tmp_path / "notify")
    monkeypatch.setenv("NOTIFY_SOCKET", str(made.path))
    monkeypatch.setenv("WATCHDOG_USEC", str(round(PERIOD_S * 1e6)))
    monkeypatch.setenv("WATCHDOG_PID", str(os.getpid()))
    yield made
    made.close()


def test_a_run_tells_that_it_is_ready_turns_and_ends(manager: Manager, live: Callable[..., Live]) -> None:
    run = live(GRAPH % 0)
    manager.wait_for("READY=1")
    manager.wait_for("WATCHDOG=1", more=5)
    assert not {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"} & set(os.environ), "a child could speak for the run"
    run.stop()
    assert manager.read()[0] == "READY=1"
    assert manager.heard[-1] == "STOPPING=1"
    assert set(manager.heard) <= {"READY=1", "WATCHDOG=1", "STOPPING=1", *status_lines(manager)}


def test_the_status_names_what_is_faulty(
    manager: Manager, live: Callable[..., Live], outside: Callable[..., Outside]
) -> None:
    run, camera = live(GRAPH % 0), outside("SPEED")
    camera.wait_for(lambda: bool(manager.read()) and bool(status_lines(manager)))
    assert status_lines(manager)[0].endswith("; camera.image: no message yet")

    def is_well() -> bool:
        camera.show("CAMERA", 7)
        time.sleep(0.02)
        manager.read()
        return status_lines(manager)[-1].endswith("; no fault")

    camera.wait_for(is_well)
    run.stop()


def test_an_engine_that_hangs_is_not_called_alive(
    manager: Manager, live: Callable[..., Live], outside: Callable[..., Outside]
) -> None:
    run, camera = live(GRAPH % (5 * PERIOD_S)), outside("SPEED")
    manager.wait_for("WATCHDOG=1")
    camera.wait_for(lambda: bool(camera.show("CAMERA", 7)) and is_silent_for(manager, 2 * PERIOD_S))
    manager.wait_for("WATCHDOG=1")
    run.stop()


def is_silent_for(manager: Manager, seconds: float) -> bool:
    """Whether nothing is heard for a while."""
    before = len(manager.read())
    time.sleep(seconds)
    return len(manager.read()) == before


def status_lines(manager: Manager) -> list[str]:
    return [line for line in manager.heard if line.startswith("STATUS=runs for ")]


def test_the_watchdog_of_another_process_is_left_alone(manager: Manager) -> None:
    environment = {"NOTIFY_SOCKET": str(manager.path), "WATCHDOG_USEC": "1000", "WATCHDOG_PID": str(os.getppid())}
    service = ServiceManager(pytest.fail, environment)
    service.tell_turn()
    service.tell_status("two\nlines\nWATCHDOG=1")
    service.tell_end()
    service.tell_ready()
    assert manager.read() == ["STATUS=two lines WATCHDOG=1", "STOPPING=1"]


def test_an_abstract_socket_is_found(tmp_path: Path) -> None:
    name = f"graphnav-{os.getpid()}-{tmp_path.name}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
        other.bind(f"\0{name}")
        ServiceManager(pytest.fail, {"NOTIFY_SOCKET": f"@{name}"}).tell_ready()
        other.settimeout(PATIENCE_S)
        assert other.recv(99) == b"READY=1"


@pytest.mark.parametrize("address", ["nowhere/notify", f"/{'x' * 200}", "vsock:2:1234"])
def test_who_cannot_be_told_is_named_once_and_the_run_goes_on(
    address: str, live: Callable[..., Live], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NOTIFY_SOCKET", address)
    looks: list[float] = []
    run = live(GRAPH % 0, on_time=looks.append)
    end_s = time.monotonic() + PATIENCE_S
    while not looks and time.monotonic() < end_s:
        time.sleep(0.01)
    run.stop()
    assert looks
    told = [line for line in run.notices if line.startswith("NOTIFY_SOCKET: ")]
    assert len(told) == 1
    assert told[0].endswith("start it by systemd with Type=notify, or without NOTIFY_SOCKET")


def test_a_reader_that_is_behind_holds_nothing_up(manager: Manager) -> None:
    service = ServiceManager(pytest.fail, {"NOTIFY_SOCKET": str(manager.path)})
    for _ in range(5000):
        service.tell_status("x" * 1000)
    service.tell_end()
    assert 0 < len(manager.read()) < 5000
