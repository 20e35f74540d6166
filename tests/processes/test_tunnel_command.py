"""``graphnav tunnel``: both ends as processes, what they print, how they end, and the errors of its options."""

from __future__ import annotations

import re
import signal
import socket
import stat
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from tests.forked_commands import forked_graphnav
from tests.lcm.listening import Listener

PATIENCE_S = 60.0


class End:
    """An end of a tunnel in a process of its own."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.printed = folder / f"{len(list(folder.iterdir()))}.txt"
        with self.printed.open("wb") as file:
            command = [str(forked_graphnav()), "tunnel", *words]
            self.process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)

    @property
    def text(self) -> str:
        """Everything that it has printed."""
        return self.printed.read_text()

    def await_text(self, pattern: str) -> re.Match[str]:
        """Wait until it has printed something that matches."""
        end_s = time.monotonic() + PATIENCE_S
        while not (found := re.search(pattern, self.text)):
            assert time.monotonic() < end_s, self.text
            assert self.process.poll() is None or re.search(pattern, self.text), self.text
            time.sleep(0.02)
        return found

    def end(self, number: int = signal.SIGINT) -> int:
        """End it by a signal; return its status."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)


@pytest.fixture
def ends(tmp_path: Path) -> Iterator[list[End]]:
    """Return a list whose processes are ended with the test."""
    made: list[End] = []
    (tmp_path / "printed").mkdir()
    yield made
    for one in made:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait()


@pytest.fixture
def key(tmp_path: Path) -> Path:
    """Return where the key is made."""
    return tmp_path / "keys" / "hosts.key"


def serve(ends: list[End], tmp_path: Path, key: Path, group: str, *words: str) -> str:
    """Serve on a free port; return that."""
    fixed = ("--serve", "--host", "127.0.0.1", "--port", "0", "--key", str(key), "--url", group)
    ends.append(End(tmp_path / "printed", *fixed, *words))
    return ends[-1].await_text(r"on port (\d+); Ctrl-C ends it\n  takes")[1]


def call(ends: list[End], tmp_path: Path, key: Path, group: str, *words: str) -> End:
    """Call this machine."""
    ends.append(End(tmp_path / "printed", "127.0.0.1", "--key", str(key), "--url", group, *words))
    return ends[-1]


def heard(url: str, far_url: str) -> list[tuple[str, bytes]]:
    """Send a message on a group until it arrives in the other one, then one more; return what arrived."""
    listener, bus = Listener(far_url), Bus(url)
    end_s = time.monotonic() + PATIENCE_S
    while not listener.received:
        assert time.monotonic() < end_s
        bus.send("TRY", b"t")
        listener._bus.handle(0.05)
    bus.send("LARGE", bytes(300_000))
    listener.listen_until(lambda: ("LARGE", bytes(300_000)) in listener.received)
    listener.close()
    bus.close()
    return listener.received


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_carries_until_a_signal_and_tells_what(
    number: int, ends: list[End], tmp_path: Path, key: Path, group: str, far_group: str
) -> None:
    port = serve(ends, tmp_path, key, group)
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    near = call(ends, tmp_path, key, far_group, "--port", port)
    near.await_text(rf"connected to 127.0.0.1:{port}")
    assert ("LARGE", bytes(300_000)) in heard(group, far_group)
    assert near.end(number) == 0
    ends[0].await_text("closed the connection")
    assert ends[0].end(number) == 0
    shown = group.partition("?")[0]
    assert ends[0].text.startswith(
        f"made a key: copy it to the hosts that call, with mode 0600: {key}\n"
        f"serving {shown} on port {port}; Ctrl-C ends it\n  takes from others: nothing: name channels by --in\n"
        "connected to 127.0.0.1:"
    )
    assert re.search(r"\n LARGE +out +1 +300 kB +0 +0 +0 +0 *\n", ends[0].text)
    assert re.search(r"\nin 0 messages, 0 B; out [\d,]+ messages, 300 kB\n$", ends[0].text)
    assert re.search(r"\n LARGE +in +1 +300 kB +0 +0 +0 +0 *\n", near.text)
    assert re.search(r"\nin [\d,]+ messages, 300 kB; out 0 messages, 0 B\n$", near.text)


def test_another_key_is_refused_with_a_sentence_on_both_sides(
    ends: list[End], tmp_path: Path, key: Path, group: str, far_group: str
) -> None:
    other = tmp_path / "other.key"
    other.write_text("ab" * 32)
    other.chmod(0o600)
    port = serve(ends, tmp_path, key, group)
    near = call(ends, tmp_path, other, far_group, "--port", port)
    assert near.process.wait(PATIENCE_S) == 2
    assert near.text.endswith(
        f"127.0.0.1:{port} refused the connection: another key\n"
        f"  copy the key of 127.0.0.1 to {other}, with mode 0600\n"
    )
    ends[0].await_text(r"\d+ s  closed connections: 1 another key \(last 127.0.0.1:\d+\)\n")


def test_hostile_bytes_disturb_nothing(ends: list[End], tmp_path: Path, key: Path, group: str, far_group: str) -> None:
    port = serve(ends, tmp_path, key, group)
    near = call(ends, tmp_path, key, far_group, "--port", port)
    near.await_text("connected to")
    for data in (b"GET / HTTP/1.1\r\n\r\n", b"\xff" * 5000, b"\x0b\0\0\0\xf1\x02\0\0\0\0\0\0\0[]"):
        with socket.create_connection(("127.0.0.1", int(port))) as other:
            other.sendall(data)
    ends[0].await_text(r"something else than frames \(last 127.0.0.1:\d+\)\n")
    assert ("LARGE", bytes(300_000)) in heard(group, far_group)
    assert near.end() == ends[0].end() == 0
    assert "Traceback" not in ends[0].text + near.text


def test_what_does_not_answer_is_called_again(
    ends: list[End], tmp_path: Path, key: Path, group: str, far_group: str
) -> None:
    port = serve(ends, tmp_path, key, group)
    assert ends[0].end() == 0
    failure = rf"\d+ s  cannot connect to 127.0.0.1, port {port}: Connection refused; trying again\n"
    short = call(ends, tmp_path, key, far_group, "--port", port, "--for", "3")
    assert short.process.wait(PATIENCE_S) == 1
    assert re.search(failure, short.text)
    near = call(ends, tmp_path, key, far_group, "--port", port)
    near.await_text(failure)
    again = ("--serve", "--host", "127.0.0.1", "--port", port, "--key", str(key), "--url", group)
    ends.append(End(tmp_path / "printed", *again))
    near.await_text(rf"connected to 127.0.0.1:{port}\n")
    assert near.end() == 0


GROUP = "udpm://239.255.1.1:7700"
ERRORS = [
    ((), "HOST: no host is named\n  write graphnav tunnel HOST, or graphnav tunnel --serve on the other host"),
    (("a", "--serve"), "--serve: one end serves, the other one calls\n  remove --serve to call a, or remove HOST"),
    (("a", "--host", "::1"), "--host: an end that calls listens nowhere\n  remove it, or add --serve"),
    (("a", "--port", "0"), "--port: port 0 is not a port to call\n  write that of the other end"),
    (("a", "--url", "x"), "--url: 'x' is not a udpm:// URL\n  write {default}, or another group of 239.0.0.0/8"),
    (("a", "--key", "{key}", "--url", GROUP), "the key {key} does not exist\n  {copy}, with mode 0600, to {key}"),
]
COPY = "'graphnav tunnel --serve' or 'run --host' on the other host makes one: copy it"


@pytest.mark.parametrize(("words", "told"), ERRORS, ids=["none", "both", "address", "port", "url", "key"])
def test_errors_say_where_what_and_what_to_do(
    words: Sequence[str], told: str, key: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["tunnel", *(word.format(key=key) for word in words)]) == 2
    assert capsys.readouterr().err == told.format(key=key, copy=COPY, default=Bus.GROUP) + "\n"


def test_an_address_that_is_none_is_an_error(key: Path, group: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tunnel", "--serve", "--host", "300.1.1.1", "--key", str(key), "--url", group]) == 2
    assert re.fullmatch(r"cannot listen on 300.1.1.1, port 7668: .+\n  choose .*\n", capsys.readouterr().err)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--in", "a("), "argument --in: 'a(' is not a regular expression: missing ), unterminated subpattern"),
        (("--out", "a@0"), "argument --out: '0' is not a number above 0"),
        (("--port", "x"), "argument --port: 'x' is not a port: write a number from 0 to 65535"),
    ],
)
def test_options_are_checked(words: Sequence[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["tunnel", "robot", *words])
    assert ended.value.code == 2
    assert told in capsys.readouterr().err


def test_a_port_that_is_in_use_is_an_error(key: Path, group: str, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        words = ["tunnel", "--serve", "--host", "127.0.0.1", "--port", port, "--key", str(key), "--url", group]
        assert main(words) == 2
    assert capsys.readouterr().err == (
        f"cannot listen on 127.0.0.1, port {port}: Address already in use\n"
        "  choose another port with --port, 0 for a free one, or another --host\n"
    )
