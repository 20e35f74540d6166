"""Names and strings of other programs are only text: no command passes on what acts on a terminal or is hidden."""

from __future__ import annotations

import io
import queue
import re
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest
from rich.segment import Segment
from textual.color import Color

from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.cli.progress import progress_bar
from graphnav.core.codec import encode, lcm_name
from graphnav.core.errors import printable
from graphnav.core.machine.console import Console
from graphnav.core.messages import About, Status, Twist
from graphnav.core.notices import print_notice
from graphnav.core.record import LogWriter
from graphnav.core.tap import Tap
from graphnav.watch.feed import Feed
from graphnav.watch.spy.live_watch import LiveWatch
from graphnav.watch.spy.screen import SpyApp

HOSTILE = [
    "\x1b]0;title\x07",
    "\x1b]8;;http://example.org\x1b\\link",
    "\x1b[2J\x1b[1;1H",
    "\x9b2J",
    "over\rwritten",
    "\u202eright",
    "\u2066isolated\u2069",
    "no\u200bwidth",
    "soft\u00adhyphen",
    "filler\u3164",
    "[red]markup[/red]",
    "[/]",
    ":warning:",
    "two\nlines",
]
OWN = re.compile(r"\x1b\[(?:\d*(?:;\d+)*m|\d*[ABK]|\?25[hl])|\r")
"""Escape sequences that rich sends: styles, moves to the begin of a display, the cursor; only to terminals."""


class Screen(io.StringIO):
    """A stream that is a terminal."""

    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


def assert_harmless(out: str) -> None:
    assert printable(out) == out


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log in which every name is hostile."""
    path = tmp_path / "log"
    with LogWriter(path) as writer:
        for number, name in enumerate(HOSTILE):
            stamp = 100_000 * number
            about = About(f"stages: {{}} # {name}\n", name, name, 7, (name,), (name,))
            writer.write(About.CHANNEL, stamp, encode(about, stamp, 0))
            status = Status(name, name, False, 0, 0, 0, 0, 0, 0, "", (), (), (), ())
            writer.write(f"{name}.status", stamp, encode(status, stamp, 0))
            writer.write(name, stamp, encode(Twist(0.1, 0.2), stamp, 0))
            writer.write(name, stamp + 1, encode(Twist(0.1, 0.2), stamp + 1, 1))
    return path


def commands(log: Path, folder: Path) -> list[list[str]]:
    """Return commands about a hostile log."""
    name = HOSTILE[0]
    plain = [[command, str(log)] for command in ("info", "spy", "top", "hz", "bw", "replay", "figure")]
    return [
        *plain,
        *([command, str(log), "--json"] for command in ("info", "spy", "top", "hz", "bw")),
        ["spy", str(log), "--once"],
        *([command, channel, str(log)] for command in ("echo", "hz", "bw") for channel in HOSTILE),
        ["echo", f"{name}.status", str(log)],
        ["echo", f"{name}.status", str(log), "--csv"],
        ["echo", f"{name}.status", str(log), "--jsonl"],
        *([command, f"{name}?", str(log)] for command in ("echo", "hz", "bw")),
        ["echo", name, str(log), "--field", name],
        ["export", str(log), "--to", "csv", "-o", str(folder / f"tables{name}"), "--force"],
        ["export", str(log), "--to", "csv", "-o", str(folder / "some"), "--channel", name],
        ["play", str(log), "--speed", "100"],
        ["play", str(log), "--channel", name],
        *([command, name] for command in ("check", "draw", "info", "stages", "types", "run", "ablate")),
        ["pub", name, name],
        [name],
    ]


def test_no_command_passes_on_what_acts_on_a_terminal(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for words in commands(log, tmp_path):
        run(words)
        told = capsys.readouterr()
        assert_harmless(told.out + told.err)


def test_on_a_terminal_only_its_own_escape_sequences_are_sent(
    log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    for words in commands(log, tmp_path):
        out, err = Screen(), Screen()
        with monkeypatch.context() as patch:
            patch.setattr(sys, "stdout", out)
            patch.setattr(sys, "stderr", err)
            run(words)
        assert_harmless(OWN.sub("", out.getvalue() + err.getvalue()))


def run(words: list[str]) -> None:
    """Run a command, whatever its status."""
    with suppress(SystemExit):
        main(words)


GRAPH = r"""
about: "\e]0;title\a \u202e [red]about[/red]"
run: {until_s: 1}
stages:
  "a": {use: evil.loud}
"""
STAGE = r'''
from graphnav import Source, Stage, Twist, hookimpl

FAMILY = "evil"


class Loud(Source):
    """Prints \x1b]0;title\x07 \u202e [red]red[/red]."""

    def step(self) -> Twist:
        print("\x1b]0;title\x07\u202e", flush=True)
        raise RuntimeError("\x1b]0;title\x07 \u202e [red]red[/red]")


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Loud]
'''


@pytest.mark.parametrize("is_terminal", [False, True])
@pytest.mark.parametrize(
    "words",
    [
        ["check", "GRAPH"],
        ["check", "GRAPH", "--resolved"],
        *(["draw", "GRAPH", "--format", kind] for kind in ("text", "svg", "mermaid", "dot")),
        ["run", "GRAPH", "--no-tap", "-v", "-o", "OUT"],
        ["profile", "GRAPH"],
        ["stages", "evil.loud"],
        ["stages"],
        ["check", "GRAPH", "--set", "a.\x1b]0;title\x07=1"],
    ],
    ids=lambda words: " ".join([words[0], *words[2:]]).replace("\x1b", "").replace("\x07", ""),
)
def test_what_stages_and_graphs_say_is_only_text(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, is_terminal: bool
) -> None:
    graph, stage = tmp_path / "[red]g\u202e.yaml", tmp_path / "evil.py"
    out, err = (Screen(), Screen()) if is_terminal else (io.StringIO(), io.StringIO())
    graph.write_text(GRAPH, encoding="utf-8")
    stage.write_text(STAGE, encoding="utf-8")
    monkeypatch.setenv("TERM", "xterm-256color")
    given = {"GRAPH": str(graph), "OUT": str(tmp_path / "out")}
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", out)
        patch.setattr(sys, "stderr", err)
        run([*(given.get(word, word) for word in words), "--plugin", str(stage)])
    told = OWN.sub("", out.getvalue() + err.getvalue())
    assert told
    assert_harmless(told)


def test_a_progress_display_reads_neither_markup_nor_escape_sequences(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    console = Console(stderr=True)
    with progress_bar(console, "[red]title[/red]", 1.0) as on_tick:
        on_tick(500_000)
        for name in HOSTILE:
            print(f"printed {name}", file=sys.stderr)
            print_notice(f"notice of {name}")
    told = OWN.sub("", screen.getvalue())
    assert "[red]title[/red]" in told
    assert r"printed \x1b]8;;http://example.org\x1b\link" in told
    assert_harmless(told)


def test_notices_of_other_runs_are_one_line_each_and_bounded(group: str, capsys: pytest.CaptureFixture[str]) -> None:
    notices: queue.Queue[str] = queue.Queue()

    def notice(text: str) -> None:
        print_notice(text)
        notices.put(text)

    tap, bus = Tap("thin", "run-1", group, notice), Bus(group)
    own = About("stages: {}\n", "", "", 7, ("twist",), (lcm_name(Twist.lcm_class),))
    tap.announce(own)
    names = [*HOSTILE[:4], "long" * 1000, "two\nlines", *(f"run-{number}" for number in range(2, 40))]
    others = threading.Event()

    def announce() -> None:
        while not others.is_set():
            for name in names:
                bus.publish(About.CHANNEL, encode(About("", "", name, 7, own.channels, own.types), 0, 0))

    sender = threading.Thread(target=announce)
    sender.start()
    told = [notices.get(timeout=20)]
    while "not reported" not in told[-1]:
        told.append(notices.get(timeout=20))
    others.set()
    sender.join()
    tap.close()
    assert len(told) == 9
    assert notices.empty()
    assert all(len(text.splitlines()) <= 2 and len(text) < 500 for text in told)
    assert_harmless(capsys.readouterr().err)


def test_the_full_screen_escapes_every_line_of_cells(group: str) -> None:
    app = SpyApp(LiveWatch(Feed(group)), Catalog(), Path.cwd())
    for name in HOSTILE:
        segments = [Segment("before "), Segment(name), Segment("\x1b7", None, [(1,)])]  # type: ignore[list-item]
        for one in app.get_line_filters():
            segments = one.apply(segments, Color(0, 0, 0))
        assert_harmless("".join(segment.text for segment in segments if not segment.control))
