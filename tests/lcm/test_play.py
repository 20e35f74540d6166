"""``graphnav play``: what is in a log is received again, in order and at its time; C and LCM's own logs included."""

from __future__ import annotations

import contextlib
import os
import pty
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import encode, lcm_text_of
from graphnav.core.messages import About, Twist
from graphnav.core.record import LogWriter

from .conftest import TOOLS
from .listening import Listener
from .recording import GRAPHNAV, events_of, wait_until

MOTOR_GRAPH = """\
about: A toy.
stages: {guard: {use: control.guard}}
outputs:
  guard.twist: {channel: BASE_CMD, type: graphnav_lcm.twist_t, motor: true, max_age_s: 0.5}
"""
LCM_ROOT = TOOLS.parent
IN_ITS_OWN_SESSION = (
    "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); os.execv(sys.argv[1], sys.argv[1:])"
)


def twist(k: int) -> bytes:
    """Return the k-th command."""
    return encode(Twist(0.1 * k, -0.5), 1000 * k, k)


def write_log(
    path: Path, n: int = 40, period_us: int = 5_000, channels: tuple[str, ...] = ("a.twist", "b.twist")
) -> Path:
    """Write commands on some channels."""
    with LogWriter(path) as log:
        for k in range(n):
            for channel in channels:
                log.write(channel, period_us * k, twist(k))
    return path


@pytest.fixture
def listener(group: str) -> Iterator[Listener]:
    """Return a listener on the test's group."""
    made = Listener(group)
    yield made
    made.close()


def test_everything_is_heard_in_order(
    tmp_path: Path, group: str, listener: Listener, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_log(tmp_path / "log")
    begin_s = time.monotonic()
    assert main(["play", str(path), "--url", group]) == 0
    assert time.monotonic() - begin_s >= 0.195
    assert listener.wait_for(80) == [(event.channel, event.data) for event in events_of(path)]
    out = capsys.readouterr().out
    url = f"{group}&recv_buf_size=2097152"
    assert out.startswith(f"playing {path}: 80 messages on 2 channels, 0.2 s, 1x\n  on {url}\n80 messages played in ")


@pytest.mark.parametrize(
    ("options", "channels", "seqs"),
    [
        (["-c", "a.*"], {"a.twist"}, range(40)),
        (["-c", "a.*", "--invert"], {"b.twist"}, range(40)),
        (["--regex", "[bc].twist"], {"b.twist"}, range(40)),
        (["--start", "0.1s"], {"a.twist", "b.twist"}, range(20, 40)),
        (["--start", "0.05", "--end", "0.1s", "-c", "a*"], {"a.twist"}, range(10, 21)),
    ],
)
def test_options_choose_what_is_played(
    tmp_path: Path, group: str, listener: Listener, options: list[str], channels: set[str], seqs: range
) -> None:
    path = write_log(tmp_path / "log")
    assert main(["play", str(path), "--url", group, "--speed", "4", *options]) == 0
    found = listener.wait_for(len(seqs) * len(channels))
    assert {channel for channel, _ in found} == channels
    assert [data for _, data in found] == [twist(k) for k in seqs for _ in channels]


def test_a_loop_ends_by_ctrl_c(tmp_path: Path, group: str, listener: Listener) -> None:
    path = write_log(tmp_path / "log", n=3)
    words = [GRAPHNAV, "play", str(path), "--url", group, "--loop", "-c", "a.twist"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        found = listener.wait_for(7)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert [data for _, data in found[:7]] == [twist(k % 3) for k in range(7)]
    assert out.splitlines()[-1].split(" played")[0].endswith(" messages")
    assert err == "stopped\n"


def test_motor_channels_are_told(
    tmp_path: Path, group: str, listener: Listener, capsys: pytest.CaptureFixture[str]
) -> None:
    said = About(MOTOR_GRAPH, lcm_text_of([Twist.lcm_class]), "", 7, ("BASE_CMD",), ("graphnav_lcm.twist_t",))
    with LogWriter(tmp_path / "log") as log:
        log.write(About.CHANNEL, 0, encode(said, 0, 0))
        log.write("BASE_CMD", 1000, twist(1))
        log.write("CAMERA", 1000, b"")
    assert main(["play", str(tmp_path / "log"), "--url", group]) == 0
    assert capsys.readouterr().err == (
        "'BASE_CMD' is a motor channel (guard.twist): a listening robot will move\n"
        "  exclude it with --invert --channel 'BASE_CMD'\n"
    )
    assert len(listener.wait_for(3)) == 3
    assert main(["play", str(tmp_path / "log"), "--url", group, "--invert", "-c", "BASE_CMD"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "graph", ["outputs: 7\n", "outputs: [a]\n", "outputs: {a: {motor: yes, channel: 3}}\n", "- x\n"]
)
def test_a_graph_of_another_shape_has_no_motors(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str], graph: str
) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write(About.CHANNEL, 0, encode(About(graph, "", "", 7, (), ()), 0, 0))
    assert main(["play", str(tmp_path / "log"), "--url", group]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--start", "3s"], "--start: 3 s is after the end: the log is 0.195 s long\n"),
        (["--start", "0.1", "--end", "0.05"], "--end: 0.05 s is before --start 0.1\n  give a later end\n"),
        (["-c", "a.twst"], "{log} holds no channel that matches the filters\n  did you mean 'a.twist'?\n"),
        (
            ["-c", "xyz", "--regex", "q+"],
            "{log} holds no channel that matches the filters\n  channels are a.twist, b.twist\n",
        ),
        (
            ["--end", "0.101", "--start", "0.1005"],
            "{log} holds no selected messages in this time range\n  give another --start or --end\n",
        ),
        (
            ["--url", "udpm://1.2.3.4"],
            f"--url: '1.2.3.4' is not a multicast address\n  write {Bus.GROUP}, or another group of 239.0.0.0/8\n",
        ),
    ],
)
def test_a_command_line_that_is_wrong_is_refused(
    tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    path = write_log(tmp_path / "log")
    url = [] if "--url" in words else ["--url", group]
    assert main(["play", str(path), *url, *words]) == 2
    assert capsys.readouterr().err == said.format(log=path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["log", "--speed", "0"], "argument --speed: '0' is not a number above 0"),
        (["log", "--start", "-1"], "argument --start"),
        (["log", "--end", "soon"], "argument --end: 'soon' is not a time: write 12.3s or 2min"),
    ],
)
def test_an_argument_that_is_wrong_is_refused(capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["play", *words])
    assert said in capsys.readouterr().err


def test_channels_that_lcm_cannot_name_are_counted(
    tmp_path: Path, group: str, listener: Listener, capsys: pytest.CaptureFixture[str]
) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("x" * 200, 0, b"1")
        log.write("y\0z", 0, b"2")
        log.write("fine", 0, b"3")
    assert main(["play", str(tmp_path / "log"), "--url", group]) == 0
    assert ("fine", b"3") in listener.wait_for(1)
    out, err = capsys.readouterr()
    assert "1 message played" in out
    assert err.startswith("not published: 2 messages: cannot publish 1 bytes on ")


def test_keys_pause_step_and_quit_in_a_terminal(tmp_path: Path, group: str, listener: Listener) -> None:
    path = write_log(tmp_path / "log", n=4, period_us=60_000_000, channels=("x",))
    outside, inside = pty.openpty()
    command = [sys.executable, "-c", IN_ITS_OWN_SESSION, GRAPHNAV, "play", "--url", group, str(path)]
    process = subprocess.Popen(command, stdin=inside, stdout=inside, stderr=inside, start_new_session=True)
    os.set_blocking(outside, False)
    shown = b""

    def is_shown(text: bytes) -> bool:
        nonlocal shown
        with contextlib.suppress(BlockingIOError, OSError):
            shown += os.read(outside, 65536)
        return text in shown

    try:
        listener.listen_until(lambda: is_shown(b"playing  ") and len(listener.received) == 1)
        assert b"keys: space pause, n next message" in shown
        os.write(outside, b" ")
        listener.listen_until(lambda: is_shown(b"paused   0."))
        os.write(outside, b"n")
        assert len(listener.wait_for(2)) == 2
        listener.listen_until(lambda: is_shown(b"paused   60.0 of 180.0 s  1x  2 messages"))
        os.write(outside, b"\x1b[C+")
        listener.listen_until(lambda: is_shown(b"paused   65.0 of 180.0 s  2x  2 messages"))
        os.write(outside, b"q")
        listener.listen_until(lambda: is_shown(b"2 messages played") and process.poll() is not None)
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.wait()
        os.close(outside)
        os.close(inside)
    assert [data for _, data in listener.received] == [twist(0), twist(1)]


def test_the_log_of_lcm_logger_is_played_and_told(
    tmp_path: Path, group: str, listener: Listener, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "theirs"
    logger = subprocess.Popen(
        [TOOLS / "lcm-logger", "--lcm-url", group, "--flush-interval", "20", path],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    bus = Bus(group)
    sent = [("twist", twist(k)) for k in range(20)] + [("FOREIGN", b"\1\2\3\4\5\6\7\x08 and more")]

    def publish_until_logged(channel: str) -> None:
        def is_logged() -> bool:
            bus.publish(channel, b"")
            return any(event.channel == channel for event in events_of(path))

        wait_until(is_logged)

    try:
        publish_until_logged("mark-start")
        for channel, data in sent:
            bus.publish(channel, data)
        publish_until_logged("mark-end")
    finally:
        logger.terminate()
        logger.wait()
        bus.close()
    listener.listen_until(lambda: sent[-1] in listener.received)
    listener.received.clear()
    assert main(["play", str(path), "--url", group, "--speed", "20", "-c", "mark*", "-c", "LCM*", "--invert"]) == 0
    listener.listen_until(lambda: sent[-1] in listener.received)
    assert [message for message in listener.received if not message[0].startswith("mark")] == sent
    capsys.readouterr()
    assert main(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "begins 20" in out
    rows = [" ".join(line.split()[:3]) for line in out.splitlines()]
    assert [row for row in rows if row.startswith(("twist", "FOREIGN"))] == [
        "FOREIGN unknown, fingerprint",
        "twist twist_t 20",
    ]


C_PROGRAM = """
#include <lcm/lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include "graphnav_lcm_twist_t.h"

static int left;

static void on_twist(const lcm_recv_buf_t *buffer, const char *channel, const graphnav_lcm_twist_t *twist, void *user)
{
    (void)buffer, (void)user;
    printf("%s %d %.3f %.3f\\n", channel, (int)twist->seq, twist->v_mps, twist->omega_radps);
    left--;
}

int main(int argc, char **argv)
{
    lcm_t *lcm = lcm_create(argv[1]);
    left = argc > 2 ? atoi(argv[2]) : 0;
    graphnav_lcm_twist_t_subscription_t *subscription = graphnav_lcm_twist_t_subscribe(lcm, "a.twist", on_twist, NULL);
    graphnav_lcm_twist_t_subscription_set_queue_capacity(subscription, 0);
    printf("ready\\n");
    fflush(stdout);
    while (left > 0 && lcm_handle_timeout(lcm, 30000) > 0)
        ;
    lcm_destroy(lcm);
    return left;
}
"""


def test_a_c_program_decodes_what_is_played(tmp_path: Path, group: str) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc")
    (tmp_path / "twist_t.lcm").write_text(lcm_text_of([Twist.lcm_class]))
    (tmp_path / "receive.c").write_text(C_PROGRAM)
    subprocess.run([TOOLS / "lcm-gen", "-c", "twist_t.lcm"], cwd=tmp_path, check=True)
    library = f"{LCM_ROOT}/lib"
    build = ["gcc", "-std=gnu11", "-Wall", "-Wextra", "-Werror", f"-I{LCM_ROOT}/include", "-I.", "-o", "receive"]
    sources = ["receive.c", "graphnav_lcm_twist_t.c", f"-L{library}", f"-Wl,-rpath,{library}", "-llcm"]
    subprocess.run([*build, *sources], cwd=tmp_path, check=True)
    path = write_log(tmp_path / "log")
    with subprocess.Popen([tmp_path / "receive", group, "40"], stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "ready\n"
        assert main(["play", str(path), "--url", group]) == 0
        lines = program.stdout.read().splitlines()
    assert program.returncode == 0
    assert lines == [f"a.twist {k} {0.1 * k:.3f} -0.500" for k in range(40)]
