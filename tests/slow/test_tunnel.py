"""A tunnel under load: cuts, many small messages, images over a link of 100 Mbit/s, other programs at its port."""

from __future__ import annotations

import json
import random
import re
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import PATIENCE_S, group_url, python, running
from testbed.slow_link import RunningLink, slow_link

from tests.targets import Targets

NUMBERED = Path(__file__).parent / "numbered.py"
BUFFER = "&recv_buf_size=2097152"
ROBOT, LAPTOP = group_url(71) + BUFFER, group_url(72) + BUFFER
FAST, MBIT_100 = 1.25e8, 1.25e7
"""Bytes per second: 1 Gbit/s, and 100 Mbit/s."""
MAX_MB = 200
CHANNEL = "NUMBERED"


class Joined(NamedTuple):
    """Both ends of a tunnel over a link, each with what it prints."""

    link: RunningLink
    robot: subprocess.Popen[bytes]
    laptop: subprocess.Popen[bytes]
    robot_text: Path
    laptop_text: Path
    port: int

    def end(self) -> None:
        """End both; what they print is complete then."""
        for process in (self.laptop, self.robot):
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE_S)


class Joining:
    """Joins the groups of a robot and a laptop over a link of some speed."""

    def __init__(self, folder: Path, cleanup: ExitStack) -> None:
        self._folder, self._cleanup = folder, cleanup

    def __call__(self, bytes_per_s: float) -> Joined:
        key = ("--key", str(self._folder / "key"))
        texts = self._folder / "robot.txt", self._folder / "laptop.txt"
        serve = [str(GRAPHNAV), "tunnel", "--serve", "--host", "127.0.0.1", "--port", "0", "--url", ROBOT, *key]
        robot = self._cleanup.enter_context(running(serve, texts[0]))
        port = int(await_text(texts[0], r"on port (\d+); Ctrl-C ends it\n  takes")[1])
        link = self._cleanup.enter_context(slow_link(port, bytes_per_s))
        call = [str(GRAPHNAV), "tunnel", "127.0.0.1", "--port", str(link.port), "--url", LAPTOP, *key]
        laptop = self._cleanup.enter_context(running(call, texts[1]))
        await_text(texts[1], "connected to")
        time.sleep(1.0)  # both know what the other one takes
        return Joined(link, robot, laptop, *texts, port)


@pytest.fixture
def join(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Joining]:
    """Return what joins two groups."""
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    with ExitStack() as cleanup:
        yield Joining(tmp_path, cleanup)


def await_text(path: Path, pattern: str) -> re.Match[str]:
    """Wait until a program has printed something that matches."""
    end_s = time.monotonic() + PATIENCE_S
    while not (found := re.search(pattern, path.read_text())):
        assert time.monotonic() < end_s, path.read_text()
        time.sleep(0.05)
    return found


def memory_mb(process: subprocess.Popen[bytes]) -> float:
    """Return the largest memory that a process has had."""
    text = Path(f"/proc/{process.pid}/status").read_text()
    found = re.search(r"VmHWM:\s+(\d+) kB", text)
    assert found
    return int(found[1]) / 1000


def row(text: Path, way: str) -> dict[str, int]:
    """Return what an end says of the channel in its table."""
    found = re.search(rf"\n {CHANNEL} +{way} +([\d,]+) +\d+ \S+ +([\d,]+) ", text.read_text())
    assert found, text.read_text()
    passed, dropped = (int(number.replace(",", "")) for number in found.groups())
    return {"passed": passed, "dropped": dropped}


def dropped_by_kernel(text: Path) -> int:
    """Return how many packets an end has lost to the kernel, as it says."""
    found = re.findall(r"([\d,]+) packets of this group dropped by the kernel", text.read_text())
    return sum(int(number.replace(",", "")) for number in found)


class Numbered:
    """A listener on the laptop's group and a sender on the robot's."""

    def __init__(self) -> None:
        words = python(NUMBERED, "hear", LAPTOP, CHANNEL)
        self._ear = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self._ear.stdout is not None
        self._ear.stdout.readline()

    @staticmethod
    def send(rate_hz: float, n_bytes: int, for_s: float) -> subprocess.Popen[str]:
        """Begin to send."""
        words = python(NUMBERED, "send", ROBOT, CHANNEL, *map(str, (rate_hz, n_bytes, for_s)))
        return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)

    def heard(self) -> dict[str, Any]:
        """Listen no more; return what was heard."""
        heard: dict[str, Any] = json.loads(self._ear.communicate()[0].splitlines()[-1])
        return heard


def outcome_of(sender: subprocess.Popen[str]) -> dict[str, Any]:
    """Wait for the end of a sender; return what it says."""
    said: dict[str, Any] = json.loads(sender.communicate()[0])
    return said


def check_load(joined: Joined, numbered: Numbered, sender: subprocess.Popen[str], targets: Targets) -> dict[str, Any]:
    """Compare what was sent, carried, dropped and heard; return all of it."""
    sent = outcome_of(sender)
    time.sleep(10.0)  # what waits arrives, and the other end is told what was dropped
    heard = numbered.heard()
    memories = memory_mb(joined.robot), memory_mb(joined.laptop)
    joined.end()
    left, came = row(joined.robot_text, "out"), row(joined.laptop_text, "in")
    lost = dropped_by_kernel(joined.robot_text)
    targets.say(
        f"sent {sent['sent']:,} at {sent['rate_hz']:,.0f}/s; the robot's end lost {lost:,} packets to its kernel"
    )
    targets.say(f"left {left}, came {came}, heard {heard}")
    targets.check("none out of order or twice", good=heard["unordered"] == heard["twice"] == 0)
    counted = left["passed"] + left["dropped"]
    is_slow = "this computer is too slow" in joined.robot_text.read_text()
    is_counted = counted <= sent["sent"] and (counted + lost >= sent["sent"] or is_slow)
    what = "; the robot's end says that it is too slow to hear the others" if is_slow else ""
    targets.check(f"{counted:,} of {sent['sent']:,} carried or counted{what}", good=is_counted)
    targets.check("both ends count alike", good=sum(left.values()) == sum(came.values()))
    targets.check(f"memory {memories[0]:.0f} and {memories[1]:.0f} MB", good=max(memories) < MAX_MB)
    return {"sent": sent, "heard": heard, "left": left, "came": came}


def test_many_small_messages(join: Joining, targets: Targets) -> None:
    joined, numbered = join(FAST), Numbered()
    done = check_load(joined, numbered, numbered.send(20_000, 100, 20), targets)
    targets.say(f"{done['left']['passed'] / done['sent']['sent']:.2%} carried")


def test_images_over_a_link_that_carries_them(join: Joining, targets: Targets) -> None:
    joined, numbered = join(MBIT_100), Numbered()
    done = check_load(joined, numbered, numbered.send(10, 922_000, 30), targets)
    targets.say(f"longest pause {done['heard']['longest_s']:.2f} s")


def test_images_over_a_link_that_does_not(join: Joining, targets: Targets) -> None:
    joined, numbered = join(MBIT_100 / 4), Numbered()
    done = check_load(joined, numbered, numbered.send(10, 922_000, 30), targets)
    targets.check(f"{done['left']['dropped']} dropped", good=done["left"]["dropped"] > 0)
    last = round(done["sent"]["rate_hz"] * 30) - 1
    targets.check(
        f"the last one that is heard is {done['heard']['last']} of {last}", good=done["heard"]["last"] >= last - 1
    )


def test_twenty_cuts(join: Joining, targets: Targets) -> None:
    joined, numbered = join(FAST), Numbered()
    chance = random.Random(1)
    sender = numbered.send(200, 1000, 60)
    for _ in range(20):
        time.sleep(chance.uniform(1.0, 3.0))
        joined.link.cut()
    time.sleep(5.0)
    again = re.findall(r" again, after ([\d.]+) s", joined.laptop_text.read_text())
    targets.check(f"{len(again)} of 20 cuts were followed by a connection", good=len(again) == 20)
    targets.say(f"after {min(map(float, again))} to {max(map(float, again))} s")
    sent = outcome_of(sender)
    time.sleep(1.0)
    heard = numbered.heard()
    targets.check("none out of order or twice", good=heard["unordered"] == heard["twice"] == 0)
    targets.check(f"{heard['heard']:,} of {sent['sent']:,} heard", good=heard["heard"] > sent["sent"] / 2)
    targets.check(f"the last one is heard ({heard['last']})", good=heard["last"] == sent["sent"] - 1)
    joined.end()


def test_other_programs_at_the_port(join: Joining, targets: Targets) -> None:
    """A thousand connections of random bytes, slow ones and silent ones, while it carries."""
    joined, numbered = join(FAST), Numbered()
    sender = numbered.send(200, 1000, 40)
    chance, silent = random.Random(2), []
    end_s, count = time.monotonic() + 35, 0
    while time.monotonic() < end_s:
        other = socket.create_connection(("127.0.0.1", joined.port))
        count += 1
        with suppress(OSError):
            other.sendall(chance.randbytes(chance.choice((1, 4, 20, 5000))))
        silent.append(other)
        if len(silent) > 50:
            silent.pop(chance.randrange(50)).close()
        time.sleep(0.01)
    for other in silent:
        other.close()
    done = check_load(joined, numbered, sender, targets)
    text = joined.robot_text.read_text()
    numbers = re.findall(r"([\d,]+) (?:something|no|closed (?:for|without))", text)
    closed = sum(int(number.replace(",", "")) for number in numbers)
    targets.check(f"{closed:,} of {count:,} others were closed and counted", good=count - 20 <= closed <= count)
    targets.check("no traceback", good="Traceback" not in text + joined.laptop_text.read_text())
    targets.check("all arrived", good=done["left"]["dropped"] == 0)
