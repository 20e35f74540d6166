"""``graphnav lcm-spy`` and Java: LCM's own spy and other Java programs decode our messages by the jar of our types."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import signal
import subprocess
import sysconfig
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import SHIPPED, encode
from graphnav.core.messages import Flow, Twist
from graphnav.core.record import LogWriter
from graphnav.core.typeinfo import file_of_lcm
from graphnav.develop.java import find_jdk, types_jar

from .conftest import TOOLS

NO_JDK = find_jdk().missing
needs_jdk = pytest.mark.skipif(bool(NO_JDK), reason=NO_JDK)
needs_xvfb = pytest.mark.skipif(shutil.which("Xvfb") is None, reason="Xvfb is not installed")
GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
LISTENER = """\
import lcm.lcm.*;

public class Listener implements LCMSubscriber {
    public static void main(String[] words) throws Exception {
        new LCM(words[0]).subscribeAll(new Listener());
        System.out.println("ready");
        while (System.in.read() >= 0) { }
        System.exit(0);
    }

    public void messageReceived(LCM lcm, String channel, LCMDataInputStream in) {
        try {
            if (channel.equals("control.twist")) {
                graphnav_lcm.twist_t m = new graphnav_lcm.twist_t(in);
                System.out.println(channel + " " + m.utime + " " + m.seq + " " + m.v_mps + " " + m.omega_radps);
            } else if (channel.equals("flow.flow")) {
                graphnav_lcm.flow_t m = new graphnav_lcm.flow_t(in);
                System.out.println(channel + " " + m.utime + " " + m.rows + " " + m.cols + " " + m.uv_px[1][2][0]);
            }
        } catch (Exception error) {
            System.out.println(error);
        }
    }
}
"""


@pytest.fixture(scope="module")
def jar(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return the jar of all types that ship."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield types_jar(SHIPPED)


@needs_jdk
def test_the_jar_is_built_once_for_the_same_types(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    jar = types_jar(SHIPPED[:2])
    built = jar.stat().st_mtime_ns
    assert types_jar(SHIPPED[:2]) == jar
    assert jar.stat().st_mtime_ns == built
    assert types_jar(SHIPPED[2:3]) != jar
    assert len(list(jar.parent.iterdir())) == 2


@needs_jdk
def test_java_decodes_what_lcm_logplayer_plays(tmp_path: Path, group: str, jar: Path) -> None:
    uv_px = (np.arange(24).reshape(3, 4, 2) / 8).astype(np.float32)
    flow = Flow(uv_px, np.ones((3, 4), np.uint8), 100_000)
    with LogWriter(tmp_path / "log") as log:
        for k in range(5):
            log.write("control.twist", 10_000 * k, encode(Twist(0.1 * k, -0.3), 10_000 * k, k))
            log.write("flow.flow", 10_000 * k, encode(flow, 10_000 * k, k))
    (tmp_path / "Listener.java").write_text(LISTENER)
    classpath = os.pathsep.join(map(str, (jar, file_of_lcm("lcm.jar"))))
    command: list[str | Path] = [
        "java",
        "-Djava.net.preferIPv4Stack=true",
        "-cp",
        classpath,
        tmp_path / "Listener.java",
        group,
    ]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as java:
        assert java.stdout is not None
        assert java.stdin is not None
        assert java.stdout.readline() == "ready\n"
        subprocess.run([TOOLS / "lcm-logplayer", "--lcm-url", group, tmp_path / "log"], check=True, capture_output=True)
        received = [java.stdout.readline().split() for _ in range(10)]
        java.stdin.close()
    twists = [words for words in received if words[0] == "control.twist"]
    flows = [words for words in received if words[0] == "flow.flow"]
    assert [(int(words[1]), int(words[2])) for words in twists] == [(10_000 * k, k) for k in range(5)]
    assert [(float(words[3]), float(words[4])) for words in twists] == [(0.1 * k, -0.3) for k in range(5)]
    assert [words[1:] for words in flows] == [[str(10_000 * k), "3", "4", str(flow.uv_px[1, 2, 0])] for k in range(5)]


@pytest.fixture
def display() -> Iterator[str]:
    """Return an X display of its own."""
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "900x650x24", "-nolisten", "tcp"]
    process = subprocess.Popen(command, pass_fds=[write_end], stderr=subprocess.DEVNULL)
    os.close(write_end)
    try:
        with os.fdopen(read_end) as number:
            yield f":{number.readline().strip()}"
    finally:
        process.terminate()
        process.wait(20)


@needs_jdk
@needs_xvfb
def test_lcm_spy_starts_with_our_types(
    tmp_path: Path, group: str, display: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    over = threading.Event()

    def publish() -> None:
        bus = Bus(group)
        for k in itertools.count():
            bus.publish("control.twist", encode(Twist(0.1, 0.2), k, k))
            if over.wait(0.02):
                break
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    command: list[str | Path] = [GRAPHNAV, "lcm-spy", group]
    try:
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
        ) as process:
            assert process.stdout is not None
            lines = iter(process.stdout.readline, "")
            try:
                found = next(match for line in lines if (match := re.search(r"Found (\d+) LCM types", line)))
                assert int(found[1]) >= len(SHIPPED)
            finally:
                os.killpg(process.pid, signal.SIGKILL)
    finally:
        over.set()
        thread.join()


def test_without_java_it_is_said_what_installs_it(
    monkeypatch: pytest.MonkeyPatch, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", "")
    assert main(["lcm-spy", group]) == 2
    assert capsys.readouterr().err == "Java is not installed\n  run as root: install a JDK with AWT\n"


@pytest.mark.parametrize(
    ("tools", "lacks"),
    [
        (["java"], "Java is installed, but no compiler (javac)"),
        (["java", "javac"], "Java is installed, but no tool jar"),
        (["java", "javac", "jar"], ""),
        (["java", "javac", "jar", "headless"], "the installed Java is headless and cannot open windows"),
    ],
)
def test_an_incomplete_java_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tools: list[str], lacks: str
) -> None:
    (tmp_path / "bin").mkdir()
    for tool in tools:
        (tmp_path / "bin" / tool).write_text("#!/bin/sh\n")
        (tmp_path / "bin" / tool).chmod(0o755)
    if "headless" in tools:
        (tmp_path / "lib").mkdir()
        (tmp_path / "lib" / "modules").touch()
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    assert find_jdk().missing == lacks


@needs_jdk
def test_without_a_display_it_is_said(
    monkeypatch: pytest.MonkeyPatch, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    assert main(["lcm-spy", group]) == 2
    assert capsys.readouterr().err == (
        "lcm-spy opens a window, but there is no display: DISPLAY is not set\n"
        "  run it in a graphical session, or watch in this terminal: graphnav spy\n"
    )


def test_only_multicast_can_be_watched(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lcm-spy", "memq://"]) == 2
    assert capsys.readouterr().err.startswith("URL: 'memq://' is not a udpm:// URL\n  write udpm://239.255.76.67:7667")
