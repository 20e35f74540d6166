"""``graphnav view --foxglove`` as a user types it."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.core.cli import main
from tests.forked_commands import forked_graphnav

from .foxglove_client import FoxgloveClient


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_prints_where_it_serves_and_ends_when_it_is_asked_to(log: Path, number: signal.Signals) -> None:
    command = [str(forked_graphnav()), "view", "--foxglove", str(log), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.fullmatch(
            rf"{re.escape(str(log))} is served to Foxglove at (ws://127\.0\.0\.1:\d+)  \(Ctrl-C exits\)\n", line
        )
        assert found, line
        with FoxgloveClient(found[1]) as client:
            client.subscribe("/control/twist")
            client.until(lambda: client.of("/control/twist"))
            process.send_signal(number)
            output, error = process.communicate(timeout=30)
    assert (process.returncode, output, error) == (130, "", "stopped\n")


def test_a_port_that_is_taken(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["view", "--foxglove", str(log), "--port", str(port)]) == 2
    assert capsys.readouterr().err == (
        f"cannot listen on 127.0.0.1, port {port}: Address already in use\n"
        "  choose another port with --port, 0 for a free one, or another --host\n"
    )


@pytest.mark.parametrize("host", ["no.such.host.invalid", "300.1.1.1", "x" * 300, "192.0.2.1"])
def test_an_address_that_is_not_this_machines(log: Path, host: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "--foxglove", str(log), "--port", "0", "--host", host]) == 2
    error = capsys.readouterr().err.splitlines()
    assert error[0] == f"anyone who can reach {host} can watch: remove --host to serve this machine only"
    assert error[1].startswith(f"cannot listen on {host}, port 0: ")


def test_an_empty_log_and_a_file_that_is_no_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "empty.lcmlog").touch()
    assert main(["view", "--foxglove", str(tmp_path / "empty.lcmlog")]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'empty.lcmlog'} is empty\n"
    (tmp_path / "other.lcmlog").write_text("not a log\n" * 10)
    assert main(["view", "--foxglove", str(tmp_path / "other.lcmlog")]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'other.lcmlog'} is not an LCM log\n"


def test_the_extra_is_named_where_it_is_missing(
    log: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "foxglove"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [_Without(), *sys.meta_path])
    assert main(["view", "--foxglove", str(log)]) == 2
    assert capsys.readouterr().err == ("'--foxglove' needs foxglove-sdk\n  pip install 'foxglove-sdk>=0.25'\n")


class _Without:
    """Finds no package of the SDK."""

    def find_spec(self, name: str, *_: object) -> None:
        if name.partition(".")[0] == "foxglove":
            raise ModuleNotFoundError(name=name)
