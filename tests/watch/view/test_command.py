"""``graphnav view`` as a user types it."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import urllib.request
from pathlib import Path

import pytest
from websockets.sync.client import connect
from websockets.typing import Origin

from graphnav.core.cli import main
from tests.forked_commands import forked_graphnav


def test_it_prints_where_the_page_is_and_ends_with_ctrl_c(log: Path) -> None:
    command = [str(forked_graphnav()), "view", str(log), "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.fullmatch(rf"{re.escape(str(log))} is shown at (http://127\.0\.0\.1:\d+/)  \(Ctrl-C exits\)\n", line)
        assert found, line
        with urllib.request.urlopen(found[1], timeout=30) as response:
            assert b"<title>graphnav view</title>" in response.read()
        with pytest.raises(ConnectionRefusedError):  # another of this machine's addresses
            socket.create_connection(("127.0.0.2", int(found[1].rpartition(":")[2].strip("/"))), timeout=30)
        origin = Origin(found[1].rstrip("/"))
        with connect(f"{origin.replace('http', 'ws')}/updates", origin=origin) as page:
            assert '"hello"' in str(page.recv(timeout=30))
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=30)
    assert (process.returncode, error) == (130, "stopped\n")


def test_a_port_that_is_taken(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["view", str(log), "--port", str(port)]) == 2
    assert capsys.readouterr().err == (
        f"cannot listen on 127.0.0.1, port {port}: Address already in use\n"
        "  choose another port with --port, 0 for a free one, or another --host\n"
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere"], "there is no nowhere\n  name a run folder, a log, a udpm:// URL or a computer: robot.local:\n"),
        (["udpm://127.0.0.1:7667"], "'127.0.0.1' is not a multicast address\n  write udpm://"),
    ],
)
def test_what_cannot_be_watched(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", *arguments, "--port", "0"]) in (1, 2)
    assert capsys.readouterr().err.startswith(said)


def test_an_empty_log_and_a_file_that_is_no_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "empty.lcmlog").touch()
    assert main(["view", str(tmp_path / "empty.lcmlog")]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'empty.lcmlog'} is empty\n"
    (tmp_path / "other.lcmlog").write_text("not a log\n" * 10)
    assert main(["view", str(tmp_path / "other.lcmlog")]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'other.lcmlog'} is not an LCM log\n"


@pytest.mark.parametrize("port", ["-1", "65536", "http", "٣", ""])
def test_a_port_is_a_number(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["view", f"--port={port}"])
    assert ended.value.code == 2
    assert f"'{port}' is not a port: write a number from 0 to 65535" in capsys.readouterr().err


@pytest.mark.parametrize("host", ["no.such.host.invalid", "300.1.1.1", "x" * 300, "192.0.2.1"])
def test_an_address_that_is_not_this_machines(log: Path, host: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", str(log), "--port", "0", "--host", host]) == 2
    error = capsys.readouterr().err.splitlines()
    assert error[0] == f"anyone who can reach {host} can watch: remove --host to serve this machine only"
    assert error[1].startswith(f"cannot listen on {host}, port 0: ")
    assert error[2] == "  choose another port with --port, 0 for a free one, or another --host"
