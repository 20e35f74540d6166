"""``graphnav`` commands as processes that are forked in milliseconds: a fresh one imports for a second or two.

`forked_graphnav` is for tests in which the process is the point, its signals, streams and status, but not its start.

``python forked_commands.py FOLDER`` makes ``FOLDER/bin/graphnav``, a program that hands its words, its environment, its
folder and its standard streams to this process, which forks. Signals that reach the program reach the command, and the
program ends as the command does. It serves until ``FOLDER`` is removed.
"""

from __future__ import annotations

import fcntl
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

from graphnav.core.machine.pins import OPT_OUT
from graphnav.core.machine.threads import ONE_THREAD

MODULES = (
    "graphnav.core.cli.run",
    "graphnav.core.pictures",
    "graphnav.core.report.pictures",
    "graphnav.core.report.summary_text",
    "graphnav.studies.commands.ablate",
    "graphnav.live.run",
    "matplotlib.figure",
    "matplotlib.backends.backend_agg",
    "pymunk",
    "rich.console",
    "scipy.stats",
    "sklearn.decomposition",
)
"""Imports of the commands, which the server does once."""
GRAPHS = ("corridor_ccw", "navigate")
"""Shipped graphs, whose families are imported."""
FOLDER = "GRAPHNAV_TESTS_FORKS"
"""The variable of the environment with the folder that all processes of the tests share."""
_LOOK_S = 1.0
"""How often the server looks whether its folder is still there."""
_STARTS_S = 240.0
_MAX_BYTES = 1 << 17
"""Of what is asked: words and environment."""
_PROGRAM = """#!{python} -IS
import json, os, signal, socket, sys
if {opt_out!r} in os.environ or "--no-portable" in sys.argv or os.environ.get("PYTHONPATH") != {python_path!r}:
    os.execv({real!r}, [{real!r}, *sys.argv[1:]])
connection = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
connection.connect({address!r})
numbers = signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT
asked = {{"words": sys.argv[1:], "folder": os.getcwd(), "environment": dict(os.environ)}}
asked["ignored"] = [number for number in numbers if signal.getsignal(number) == signal.SIG_IGN]
for number in numbers:
    signal.signal(number, lambda number, _: connection.send(bytes([number])))
socket.send_fds(connection, [json.dumps(asked).encode()], [0, 1, 2])
answer = connection.recv(2)
if answer[:1] == b"k":
    signal.signal(answer[1], signal.SIG_DFL)
    os.kill(os.getpid(), answer[1])
sys.exit(answer[1])
"""


@cache
def forked_graphnav() -> Path:
    """Return a program ``graphnav`` whose commands are forked, not started; the first call starts the server."""
    folder = Path(os.environ[FOLDER])
    program = folder / "bin" / "graphnav"
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not program.exists():
            with (folder / "server.txt").open("w") as printed:
                command = [sys.executable, "-P", __file__, str(folder)]
                subprocess.run(command, check=True, stdin=subprocess.DEVNULL, stdout=printed, stderr=printed)
        end_s = time.monotonic() + _STARTS_S
        while not program.exists():
            assert time.monotonic() < end_s, (folder / "server.txt").read_text()
            time.sleep(0.05)
    return program


def main(folder: Path) -> None:
    """Import, and serve until the folder is removed, in a session of its own: the process that was started ends."""
    if os.fork():
        return
    os.setsid()
    os.environ.update(ONE_THREAD)
    for module in MODULES:
        importlib.import_module(module)
    _load_graphs()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the kernel collects those that watch over a command
    address = folder / "forks"
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listener:
        listener.bind(str(address))
        listener.listen(32)
        _write_program(folder, address)
        while address.exists():
            if not select.select([listener], [], [], _LOOK_S)[0]:
                continue
            connection = listener.accept()[0]
            if os.fork() == 0:
                listener.close()
                _serve(connection)
            connection.close()


def _load_graphs() -> None:
    from graphnav.core.catalog import Catalog
    from graphnav.core.graph import load_graph

    for graph in GRAPHS:
        load_graph(graph, Catalog())


def _write_program(folder: Path, address: Path) -> None:
    program = folder / "bin" / "graphnav"
    program.parent.mkdir()
    text = _PROGRAM.format(
        python=sys.executable,
        opt_out=OPT_OUT,
        python_path=os.environ.get("PYTHONPATH"),
        real=str(Path(sys.executable).with_name("graphnav")),
        address=str(address),
    )
    part = program.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.chmod(0o755)
    part.rename(program)


def _serve(connection: socket.socket) -> NoReturn:
    """Run one command; hand it signals, kill it where the program that asked for it was killed, tell how it ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    data, streams, _, _ = socket.recv_fds(connection, _MAX_BYTES, 3)
    pid = os.fork()
    if pid == 0:
        connection.close()
        _be(json.loads(data), streams)
    for stream in streams:
        os.close(stream)
    ended = os.pidfd_open(pid)
    awaited: list[Any] = [connection, ended]
    while ended not in (ready := select.select(awaited, [], [])[0]):
        asked = connection.recv(1) if connection in ready else b""
        signal.pidfd_send_signal(ended, asked[0] if asked else signal.SIGKILL)
        if not asked:
            os._exit(1)
    status = os.waitpid(pid, 0)[1]
    if os.WIFSIGNALED(status):
        connection.send(bytes([ord("k"), os.WTERMSIG(status)]))
    else:
        connection.send(bytes([ord("e"), os.WEXITSTATUS(status)]))
    os._exit(0)


def _be(asked: dict[str, Any], streams: list[int]) -> NoReturn:
    """Be the command."""
    for place, stream in enumerate(streams):
        os.dup2(stream, place)
        os.close(stream)
    sys.stdin = os.fdopen(0, encoding="utf-8", closefd=False)
    sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = os.fdopen(2, "w", encoding="utf-8", errors="backslashreplace", buffering=1, closefd=False)
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    tempfile.tempdir = None  # of the environment
    sys.argv = ["graphnav", *asked["words"]]
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
        if number in asked["ignored"]:
            signal.signal(number, signal.SIG_IGN)
    from graphnav.__main__ import main as graphnav

    status = 1
    try:
        status = graphnav()
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    except BaseException:  # noqa: BLE001 - as the interpreter does
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
