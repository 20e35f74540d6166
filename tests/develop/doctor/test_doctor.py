"""``graphnav doctor``: everything is told with what fixes it, for programs too, and for a graph."""

from __future__ import annotations

import json
import os
import pty
import shlex
import subprocess
import sys
import sysconfig
import termios
import threading
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.graph import load_graph
from graphnav.core.large_messages.child import FRAGMENT_BYTES
from graphnav.core.machine.instruction_set import PORTABLE
from graphnav.core.machine.pins import OPT_OUT, lacking
from graphnav.core.machine.receive_buffer import ReceiveBuffer
from graphnav.core.runner.recording.log_forecast import size_text
from graphnav.develop.doctor import Finding, run_checks
from graphnav.develop.doctor.network import message_sizes

PYTHON = sys.executable
GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"


def findings(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, dict[str, Any]]]:
    """Return the status and what is told to programs, by subject."""
    status = main(["doctor", "--json", *words])
    return status, {finding["subject"]: finding for finding in json.loads(capsys.readouterr().out)}


def test_people_and_programs_are_told_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    status, told = findings(capsys)
    assert main(["doctor"]) == status
    lines = capsys.readouterr().out.splitlines()
    heads = [line for line in lines if not line.startswith(" ")]
    assert [line[5:].partition(": ")[0] for line in heads] == list(told)
    marks = {"ok ": (True, True), "FIX": (False, True), "opt": (False, False)}
    for line, finding in zip(heads, told.values(), strict=True):
        fine, needed = marks[line[:3]]
        assert finding["fine"] == fine
        assert fine or finding["needed"] == needed
    assert status == int(any(finding["needed"] and not finding["fine"] for finding in told.values()))
    assert {"multicast", "receive buffer", "lcm", "java", "terminal graphics", "family plane"} <= set(told)


def test_what_is_not_fine_has_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    _, told = findings(capsys)
    assert all(finding["fix"] for finding in told.values() if not finding["fine"])


@pytest.mark.parametrize("opted_out", [False, True])
def test_portable_logs_are_told(opted_out: bool) -> None:
    if lacking():
        pytest.skip(lacking())
    words = [str(GRAPHNAV), "doctor", "--json"]
    own = os.environ | ({OPT_OUT: "0"} if opted_out else {})
    for name in ("OPENBLAS_CORETYPE", "OPENCV_CPU_DISABLE", "OPENCV_IPP", "NPY_DISABLE_CPU_FEATURES"):
        own.pop(name, None)
    done = subprocess.run(words, env=own, capture_output=True, text=True, check=False)
    told = next(one for one in json.loads(done.stdout) if one["subject"] == "instruction set")
    if not opted_out:
        assert (told["fine"], told["seen"]) == (True, f"{PORTABLE}: logs are the same on every machine that has them")
    elif not told["fine"]:
        assert told["seen"].endswith(": logs are the same only on such CPUs")
        assert told["fix"] == f"unset {OPT_OUT}"


def test_every_extra_of_users_is_looked_at(capsys: pytest.CaptureFixture[str]) -> None:
    _, told = findings(capsys)
    assert "extra cluster" in told
    assert "extra dev" not in told
    assert told["extra cluster"]["needed"] is False


def test_without_java_the_command_that_installs_it_is_said(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    status, told = findings(capsys)
    assert told["java"] == {
        "subject": "java",
        "fine": False,
        "seen": "Java is not installed; 'graphnav lcm-spy' needs a JDK",
        "fix": "install a JDK with AWT",
        "needed": False,
    }
    assert status == int(any(finding["needed"] and not finding["fine"] for finding in told.values()))


def test_a_buffer_holds_at_least_a_packet() -> None:
    buffer = ReceiveBuffer.measured(ReceiveBuffer.REQUESTED_BYTES)
    assert buffer.packets >= 1
    assert buffer.granted_bytes >= buffer.held_bytes
    assert ReceiveBuffer.measured(4096).packets <= buffer.packets


def test_a_buffer_of_the_needed_size_holds_the_message() -> None:
    for n_packets in (1, 3, 20):
        n_bytes = n_packets * FRAGMENT_BYTES
        asked = ReceiveBuffer.needed(n_bytes)
        assert asked >= ReceiveBuffer.REQUESTED_BYTES
        if asked <= ReceiveBuffer.limit():
            assert ReceiveBuffer.measured(asked).held_bytes >= n_bytes
    assert (
        ReceiveBuffer.needed(100 * FRAGMENT_BYTES + 1)
        == ReceiveBuffer.needed(101 * FRAGMENT_BYTES)
        > ReceiveBuffer.REQUESTED_BYTES
    )


def test_sizes_of_a_lockstep_graph_are_measured() -> None:
    graph = load_graph("corridor_ccw", Catalog())
    sizes = {size.channel: size for size in message_sizes(graph)}
    assert sizes["robot.image"].n_bytes == pytest.approx(160 * 120, abs=200)
    assert sizes["flow.flow"].n_bytes > 8 * 160 * 120
    assert not any(size.assumed for size in sizes.values())


def test_sizes_of_a_live_graph_are_those_that_come_in_and_leave() -> None:
    graph = load_graph("robot_live", Catalog())
    sizes = {size.channel: size for size in message_sizes(graph)}
    assert set(sizes) == {"CAMERA", "ODOMETRY", "BEACON", "BASE_LIMITS"}
    assert sizes["CAMERA"].n_bytes == pytest.approx(160 * 120, abs=200)
    (camera,) = message_sizes(load_graph("navigate_live", Catalog()))
    assert (camera.channel, camera.n_bytes, camera.assumed) == ("CAMERA", 921_600, "640x480 RGB")


def told_of(graph: str, asked_bytes: int, monkeypatch: pytest.MonkeyPatch) -> Finding:
    """Return the finding about the receive buffer where the URL requests so many bytes."""
    monkeypatch.setenv("LCM_DEFAULT_URL", f"udpm://239.255.77.1:7667?recv_buf_size={asked_bytes}")
    loaded = load_graph(graph, Catalog())
    return next(finding for finding in run_checks(loaded) if finding.subject == "receive buffer")


def test_the_buffer_that_the_url_requests_is_compared_with_the_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    held = size_text(ReceiveBuffer.measured(212_992).held_bytes)
    fine = told_of("robot_live", 212_992, monkeypatch)
    assert fine.fine
    assert fine.seen == (
        f"holds messages up to {held} of senders that leave no gaps, with recv_buf_size=212992 of "
        f"udpm://239.255.77.1:7667 (net.core.rmem_max is {ReceiveBuffer.limit()})"
    )
    lost = told_of("navigate_live", 212_992, monkeypatch)
    assert not lost.fine
    assert lost.needed
    assert lost.seen.endswith("; navigate_live loses 922 kB for CAMERA (assumed: 640x480 RGB)")
    as_root = (
        f"sysctl -w net.core.rmem_max={ReceiveBuffer.REQUESTED_BYTES}; "
        if ReceiveBuffer.limit() < ReceiveBuffer.REQUESTED_BYTES
        else ""
    )
    assert lost.fix == f"{as_root}recv_buf_size={ReceiveBuffer.REQUESTED_BYTES} in its URL"
    if ReceiveBuffer.limit() >= ReceiveBuffer.REQUESTED_BYTES:
        fine = told_of("navigate_live", ReceiveBuffer.REQUESTED_BYTES, monkeypatch)
        assert fine.fine
        assert fine.seen.endswith("; navigate_live needs 922 kB for CAMERA (assumed: 640x480 RGB)")


def test_what_graphnav_sends_itself_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    fine = told_of("corridor_ccw", 4096, monkeypatch)
    assert fine.fine
    assert "; corridor_ccw sends with --tap full " in fine.seen
    assert fine.seen.endswith(", with gaps")


def test_a_graph_that_is_wrong_is_a_users_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "corridor_cww"]) == 2
    assert "corridor_cww" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("attributes", "kitty", "said"),
    [
        (b"\x1b[?62;4;22c", b"", "sixel, half blocks"),
        (b"\x1b[?62;c", b"\x1b_Gi=31;OK\x1b\\", "kitty, half blocks"),
        (b"\x1b[?1;2c", b"", "half blocks"),
        (b"", b"", "half blocks"),
        (b"\x1b]0;junk\x07\xff\xff", b"", "half blocks"),
    ],
)
def test_the_terminal_is_asked_and_left_as_it_was(attributes: bytes, kitty: bytes, said: str) -> None:
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)

    def answer() -> None:
        while True:
            try:
                read = os.read(ours, 1024)
            except OSError:
                return
            if b"\x1b_G" in read:
                os.write(ours, kitty)
            if b"\x1b[c" in read:
                os.write(ours, attributes)

    read_end, write_end = os.pipe()
    patience_s = 30.0 if attributes.endswith(b"c") else 0.5  # other tests may take all processors for a while
    command = (
        f"from graphnav.core.machine import terminal_graphics as asking\nasking._TIMEOUT_S = {patience_s}\n"
        "from graphnav.develop.doctor.installation import terminal_graphics\n"
        f"open({write_end}, 'w').write(terminal_graphics().seen)"
    )
    threading.Thread(target=answer, daemon=True).start()
    process = subprocess.Popen(
        ["setsid", "--ctty", PYTHON, "-c", command],
        stdin=theirs,
        stdout=theirs,
        stderr=subprocess.PIPE,
        env={**os.environ, "TERM": "xterm-256color", "TMUX": "", "STY": ""},
        pass_fds=[write_end],
    )
    os.close(write_end)
    errors = process.communicate(timeout=60)[1]
    assert process.returncode == 0, errors
    assert os.read(read_end, 1000).decode() == said
    assert termios.tcgetattr(theirs) == before
    for fd in (read_end, theirs, ours):
        os.close(fd)


def test_no_terminal_is_not_asked() -> None:
    done = subprocess.run([GRAPHNAV, "doctor", "--json"], stdin=subprocess.DEVNULL, capture_output=True, check=False)
    told = {finding["subject"]: finding for finding in json.loads(done.stdout)}
    assert told["terminal graphics"]["seen"] == "not checked: not a terminal"


def test_a_network_without_multicast_is_told_with_what_makes_a_route() -> None:
    command = ["unshare", "--user", "--map-root-user", "--net", "--", str(GRAPHNAV), "doctor", "--json"]
    if subprocess.run([*command[:5], "true"], capture_output=True, check=False).returncode:
        pytest.skip("this kernel gives no network namespace")
    done = subprocess.run(command, capture_output=True, check=False)
    told = {finding["subject"]: finding for finding in json.loads(done.stdout)}
    assert done.returncode == 1
    assert not told["multicast"]["fine"]
    fixed = f"ip link set lo up && {told['multicast']['fix']} && {shlex.quote(str(GRAPHNAV))} doctor --json"
    done = subprocess.run([*command[:5], "sh", "-c", fixed], capture_output=True, check=False)
    told = {finding["subject"]: finding for finding in json.loads(done.stdout)}
    assert told["multicast"]["fine"]
