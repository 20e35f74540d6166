"""``graphnav doctor --host`` with ssh on this machine: everything that is fine, and what is not."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from typing import Any

import pytest

import graphnav
from graphnav.core.cli import main
from tests.processes.conftest import PATIENCE_S, STAGES
from tests.processes.over_ssh import DEPLOY, GRAPH, Robot, write


def findings(robot: Robot) -> dict[str, dict[str, Any]]:
    """Return what is found of the host, by subject."""
    doctor = robot.start("doctor", "--json", "--host", "jetson")
    told, printed = doctor.communicate(timeout=PATIENCE_S)
    assert doctor.returncode in {0, 1}, printed
    return {finding["subject"].removeprefix("jetson: "): finding for finding in json.loads(told)}


def test_all_of_a_host_is_checked(robot: Robot) -> None:
    found = findings(robot)
    own = ["address", "ssh", "clock", "graphnav", f"port {robot.port}", "process eyes"]
    assert list(found)[: len(own)] == own
    assert all(found[subject]["fine"] for subject in own), found
    assert found["address"]["seen"] == "127.0.0.1"
    assert found["graphnav"]["seen"] == f"version {graphnav.__version__}, as here"
    assert {"lcm", "receive buffer", "family plane"} <= set(found), "the doctor there"


def test_another_graph_there_is_found(robot: Robot) -> None:
    write(robot.server.home, DEPLOY, first="{what: shut, at: 900}")
    found = findings(robot)["process eyes"]
    assert not found["fine"]
    assert "it cannot live on the host jetson: it has another graph" in found["seen"]
    assert found["fix"] == "copy graph and plugins to the host"


def test_a_port_that_is_taken_is_found(robot: Robot) -> None:
    with socket.create_server(("", robot.port)):
        found = findings(robot)
    assert not found[f"port {robot.port}"]["fine"]
    assert f"port {robot.port} cannot be used: Address already in use" in found[f"port {robot.port}"]["seen"]
    assert "process eyes" not in found


@pytest.mark.parametrize(
    ("given", "subject", "seen"),
    [
        ({"address": "jetson.invalid"}, "address", "jetson.invalid is not known"),
        ({"ssh_port": 1}, "ssh", "no ssh server answers: Connection refused"),
        ({"command": "graphnaf"}, "graphnav", "its shell does not find 'graphnaf'"),
        ({"command": "echo graphnav 0.0.1 #"}, "graphnav", f"graphnav 0.0.1, but {graphnav.__version__} is here"),
    ],
)
def test_the_first_fault_is_found(robot: Robot, given: dict[str, object], subject: str, seen: str) -> None:
    robot.write_hosts(**given)
    found = findings(robot)
    assert list(found)[-1] == subject
    assert seen in found[subject]["seen"]
    assert found[subject]["fix"]
    assert [one["fine"] for one in found.values()] == [True] * (len(found) - 1) + [False]


def test_a_host_that_is_not_of_the_graph_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, DEPLOY)
    (tmp_path / "hosts.yaml").write_text("hosts: {jetson: {address: 127.0.0.1}}\n")
    assert main(["doctor", str(tmp_path / GRAPH), "--plugin", str(STAGES), "--host", "orin"]) == 2
    said = "--host: no process of steps lives on the host 'orin'\n  its hosts are jetson\n"
    assert capsys.readouterr().err == said
    assert main(["doctor", "--host", "orin"]) == 2
    assert capsys.readouterr().err == "--host: no graph is named\n  write graphnav doctor GRAPH --host NAME\n"
