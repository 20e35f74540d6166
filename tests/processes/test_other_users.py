"""Another user of the machine neither reads nor writes what goes between a run and its processes."""

from __future__ import annotations

import os
import socket
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav.core.graph import Graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import run_recorded
from graphnav.processes import child
from graphnav.processes.frames import Frame, Kind, send
from graphnav.processes.run import run_processes
from graphnav.processes.supervisor import Supervisor
from tests.processes.conftest import OTHER_USER, OtherUser, kill, restarted, steps_graph

pytestmark = pytest.mark.skipif(os.getuid() != 0, reason="only root can become another user")

BEGIN_US = 1_000_000


@pytest.fixture
def open_folder(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a folder that every user may enter, in which runs make those of their sockets."""
    tmp_path_factory.getbasetemp()  # pytest's own is made before, and elsewhere
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        monkeypatch.setattr(tempfile, "tempdir", name)
        yield folder


def answer_frame() -> bytes:
    """Return the bytes of an answer as a process sends it."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        send(ours, Frame(Kind.ANSWER, {"value": None, "error": None}))
        return theirs.recv(9999)


def log_in_one_process(graph: Graph, folder: Path) -> bytes:
    folder.mkdir()
    run_recorded(graph, graph.make_stages(), folder)
    return (folder / RunFolder.LOG).read_bytes()


@pytest.mark.parametrize("is_opened", [False, True])
def test_another_user_is_not_heard_and_hears_nothing(open_folder: Path, tmp_path: Path, is_opened: bool) -> None:
    """Also where the folder was opened, and while a process is being started again, whose place it could take."""
    graph = steps_graph(tmp_path, deploy="deploy: {left: {stages: [clock, second]}, right: {stages: [third]}}")
    supervisors: list[Supervisor] = []
    others: list[OtherUser] = []

    def on_tick(utime: int) -> None:
        if utime < BEGIN_US or others:
            return
        (folder,) = open_folder.glob("graphnav-*")
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        if is_opened:
            for path in (folder, folder / "run"):
                path.chmod(0o777)
        kill(supervisors[0], "right")
        others.append(OtherUser(folder / "run", answer_frame()))

    many = tmp_path / "many"
    many.mkdir()
    summary = run_processes(
        restarted(graph),
        graph.make_stages(),
        many,
        supervised=supervisors.append,
        on_tick=on_tick,
        notice=lambda _: None,
    )
    first, last = others[0].first, others[0].end()
    assert (first, last) == (("connected", "no answer") if is_opened else ("PermissionError", "PermissionError"))
    assert (summary.processes or {})["right"]["restarts"] == 1
    assert (many / RunFolder.LOG).read_bytes() == log_in_one_process(replace(graph, deploy={}), tmp_path / "one")


def test_a_process_tells_nothing_to_a_socket_of_another_user(open_folder: Path) -> None:
    path = open_folder / "run"
    code = f"""if True:
        import os, socket
        os.setgroups([])
        os.setgid({OTHER_USER})
        os.setuid({OTHER_USER})
        listener = socket.socket(socket.AF_UNIX)
        listener.bind({str(path)!r})
        listener.listen()
        print("listens", flush=True)
        link, _ = listener.accept()
        print(len(link.recv(9999)))
    """
    open_folder.chmod(0o777)
    with subprocess.Popen([sys.executable, "-I", "-c", code], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "listens\n"
        words = [sys.executable, "-m", child.__name__, str(path), str(os.getpid())]
        assert subprocess.run(words, check=False, timeout=60).returncode == 1
        assert other.stdout.readline() == "0\n"
