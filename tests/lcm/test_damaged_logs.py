"""Truncated logs, and logs with flipped bits: intact parts are used, losses are reported, nothing crashes."""

from __future__ import annotations

import json
import os
import random
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.codec import encode, lcm_text_of
from graphnav.core.errors import LogError
from graphnav.core.messages import About, Twist
from graphnav.core.record import Event, LogWriter, Recording

SAID = About(
    "about: A toy.\nstages: {}\n", lcm_text_of([Twist.lcm_class]), "", 7, ("twist",), ("graphnav_lcm.twist_t",)
)
HEADER_BYTES = 28


def events_of(path: Path) -> list[Event]:
    """Return what can be read of a log."""
    with Recording(path) as recording:
        return list(recording.events())


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a log of a description and four commands."""
    path = tmp_path_factory.mktemp("small") / "small.lcmlog"
    with LogWriter(path) as log:
        log.write(About.CHANNEL, 0, encode(SAID, 0, 0))
        for k in range(4):
            log.write("twist", 100_000 * k, encode(Twist(0.1, 0.2), 100_000 * k, k))
    return path


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a log of 3000 events of many sizes, random bytes in them."""
    path, rng = tmp_path_factory.mktemp("large") / "large.lcmlog", random.Random(4)
    with LogWriter(path) as log:
        for k in range(3000):
            size = rng.choice((0, 8, 200, 200, 200, 5000, 70_000 if k % 50 == 0 else 30))
            log.write(rng.choice(("a", "robot.image", "x" * 63)), 1000 * k, rng.randbytes(size))
    return path


def ends_of(events: list[Event]) -> list[int]:
    """Return where each event ends in the file."""
    ends = [0]
    for event in events:
        ends.append(ends[-1] + HEADER_BYTES + len(event.channel) + len(event.data))
    return ends[1:]


def test_a_log_cut_anywhere_is_read_up_to_the_cut(small: Path, tmp_path: Path) -> None:
    data, events = small.read_bytes(), events_of(small)
    ends = ends_of(events)
    for cut in range(1, len(data)):
        (tmp_path / "cut").write_bytes(data[:cut])
        with Recording(tmp_path / "cut") as recording:
            n_complete = sum(end <= cut for end in ends)
            assert list(recording.events()) == events[:n_complete], cut
            assert recording.damaged == []
            lost = cut - (ends[n_complete - 1] if n_complete else 0)
            assert (recording.truncated.n_bytes if recording.truncated is not None else 0) == lost


def test_a_large_log_cut_at_random_is_read_up_to_the_cut(large: Path, tmp_path: Path) -> None:
    data, events, rng = large.read_bytes(), events_of(large), random.Random(1)
    ends = ends_of(events)
    for _ in range(40):
        cut = rng.randrange(1, len(data))
        (tmp_path / "cut").write_bytes(data[:cut])
        assert events_of(tmp_path / "cut") == events[: sum(end <= cut for end in ends)], cut


def test_a_flipped_bit_costs_one_event(small: Path, tmp_path: Path) -> None:
    data, events = small.read_bytes(), events_of(small)
    ends = ends_of(events)
    heads = {begin + k for begin in (0, *ends) for k in range(HEADER_BYTES + len(About.CHANNEL))}
    for bit in (bit for bit in range(8 * len(data)) if bit // 8 in heads or bit % 8 == 3):
        hit = sum(end <= bit // 8 for end in ends)
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        (tmp_path / "flipped").write_bytes(flipped)
        with Recording(tmp_path / "flipped") as recording:
            found = list(recording.events())
            intact = [event for number, event in enumerate(events) if number != hit]
            assert [event for event in found if event in intact] == intact, (bit, hit)
            assert len(found) >= len(events) or recording.damaged or recording.truncated


def test_random_damage_leaves_all_other_events(large: Path, tmp_path: Path) -> None:
    data, events, rng = large.read_bytes(), events_of(large), random.Random(2)
    ends = ends_of(events)
    for _ in range(15):
        damaged = bytearray(data)
        hit = set()
        for _ in range(5):
            at = rng.randrange(len(data) - 100)
            damaged[at : at + 40] = rng.randbytes(40)
            hit |= {
                number for number, end in enumerate(ends) if end > at and (ends[number - 1] if number else 0) < at + 40
            }
        (tmp_path / "damaged").write_bytes(damaged)
        left = [event for number, event in enumerate(events) if number not in hit]
        found = set(events_of(tmp_path / "damaged"))
        assert all(event in found for event in left)


def test_damage_in_the_first_event_does_not_hide_the_others(small: Path, tmp_path: Path) -> None:
    data, events = small.read_bytes(), events_of(small)
    (tmp_path / "log").write_bytes(b"\0" * 50 + data[50:])
    with Recording(tmp_path / "log") as recording:
        assert list(recording.events()) == events[1:]
        assert [tuple(one) for one in recording.damaged] == [(0, ends_of(events)[0])]


def test_a_tail_of_zeros_is_damage(small: Path, tmp_path: Path) -> None:
    data = small.read_bytes()
    (tmp_path / "log").write_bytes(data + bytes(5000))
    with Recording(tmp_path / "log") as recording:
        assert list(recording.events()) == events_of(small)
        assert [tuple(one) for one in recording.damaged] == [(len(data), 5000)]
        assert str(recording.damaged[0]) == f"5000 bytes from byte {len(data)} are not an event"


def test_a_log_inside_a_message_is_not_taken_for_events(small: Path, tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        for k in range(3):
            log.write("file", k, small.read_bytes())
    assert [event.channel for event in events_of(tmp_path / "log")] == ["file"] * 3


def test_info_and_play_take_every_cut(
    small: Path, tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    data = small.read_bytes()
    ends = ends_of(events_of(small))
    for cut in sorted({*range(0, 40, 2), *(end + k for end in ends for k in (-1, 0, 1, 5)), len(data) - 1}):
        (tmp_path / "cut").write_bytes(data[: min(cut, len(data))])
        assert main(["info", str(tmp_path / "cut"), "--json"]) == 0
        said = json.loads(capsys.readouterr().out)
        n_complete = sum(end <= cut for end in ends)
        assert said["messages"] == n_complete
        assert main(["info", str(tmp_path / "cut")]) == 0
        assert ("is truncated" in capsys.readouterr().out) == (cut not in {0, *ends} and cut < len(data))
        status = main(["play", str(tmp_path / "cut"), "--url", group, "--speed", "100"])
        out, err = capsys.readouterr()
        assert status == (0 if n_complete else 1)
        assert f"{n_complete} message" in out if n_complete else "holds no message" in err


def test_info_and_play_take_flipped_bits(
    small: Path, tmp_path: Path, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    data, rng = small.read_bytes(), random.Random(3)
    for _ in range(30):
        flipped = bytearray(data)
        for _ in range(rng.choice((1, 2, 20))):
            flipped[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        (tmp_path / "log").write_bytes(flipped)
        for words in (["info"], ["info", "--json"], ["play", "--url", group, "--speed", "1000"]):
            assert main([words[0], str(tmp_path / "log"), *words[1:]]) in {0, 1}
            out, err = capsys.readouterr()
            assert "Traceback" not in out + err
            assert [line for line in (out + err).split("\n") if not line.isprintable()] == []


@pytest.mark.parametrize("command", ["info", "play"])
@pytest.mark.parametrize(
    ("data", "said"),
    [(b"stages: {}\n", "{log} is not an LCM log\n"), (b"\0" * 100, "{log} is not an LCM log\n")],
)
def test_what_is_not_a_log_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, data: bytes, said: str
) -> None:
    (tmp_path / "log").write_bytes(data)
    assert main([command, str(tmp_path / "log")]) == 1
    assert capsys.readouterr().err == said.format(log=tmp_path / "log")


def test_an_empty_log_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log").touch()
    assert main(["info", str(tmp_path / "log")]) == 0
    said = capsys.readouterr().out
    assert said == f"{tmp_path / 'log'}: 0 B, 0 messages on 0 channels, 0.000 s\nthe log holds no messages\nno damage\n"
    assert main(["play", str(tmp_path / "log")]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'log'} holds no messages\n"


@contextmanager
def without_privileges() -> Iterator[None]:
    """Drop the privileges of root, who may read all files."""
    own = os.geteuid()
    if not own:
        os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(own)


@pytest.mark.parametrize("command", ["info", "play"])
def test_a_log_that_may_not_be_read_is_said(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    path = tmp_path / "log"
    path.write_bytes(small.read_bytes())
    for folder in (tmp_path, *tmp_path.parents):
        if folder.stat().st_uid == os.geteuid() and str(folder).startswith("/tmp/"):
            folder.chmod(0o755)
    path.chmod(0)
    with without_privileges():
        assert main([command, str(path)]) == 1
    assert capsys.readouterr().err == f"{path}: Permission denied\n"


def test_a_description_that_is_damaged_hides_nothing(small: Path, tmp_path: Path) -> None:
    data = bytearray(small.read_bytes())
    data[HEADER_BYTES + len(About.CHANNEL) + 24] ^= 0xFF  # a length
    (tmp_path / "log").write_bytes(data)
    with Recording(tmp_path / "log") as recording:
        assert recording.about is None
        assert recording.channels["twist"] is Twist.lcm_class
        with pytest.raises(LogError, match="does not hold the graph that produced it"):
            _ = recording.graph


def test_the_description_may_come_later(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("twist", 0, encode(Twist(0.0, 0.0), 0, 0))
        log.write(About.CHANNEL, 1, encode(SAID, 0, 0))
    with Recording(tmp_path / "log") as recording:
        assert recording.about is not None
        assert recording.about.seed == 7
