"""Exchange logs and traffic both ways between graphnav and other programs: LCM's own, C, Java, lcm-cli."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import lcm

from acceptance.drives import GRAPHNAV, say
from acceptance.foreign_listeners import Sums, c_listener, java_listener, played
from acceptance.foreign_log import foreign_lines
from acceptance.processes import await_file, end, group_url
from acceptance.their_spy import their_spy_line
from graphnav import Recording
from graphnav.core.record import ABOUT, LOG

ROOT = Path(__file__).resolve().parents[2]
LCM_CLI = Path(sysconfig.get_path("scripts")) / "lcm"
_BUFFER = "&recv_buf_size=2097152"
_DRIVE_S = 15
_MIN_JAVA_SHARE = 0.99
"""Java programs have the receive buffer of a stock machine, whatever their URL says."""
_TESTS = ("test_tools", "test_lcm_spy", "test_lcm_cli", "test_given_types", "test_play", "test_record", "test_info")

Line = tuple[bool, str]


def exchange_item(seeds: Sequence[int], _jobs: int) -> bool:
    """Let each read, play, decode and show what the other wrote; print how many messages each path carried."""
    folder = Path(tempfile.mkdtemp(prefix="graphnav-exchange-"))
    url = group_url(231)
    ours = folder / "ours.lcmlog"
    lines = [_logger_line(folder, url, seeds[0]), _record_line(folder, ours, url, seeds[0])]
    lines += [_c_line(folder, ours, url), _java_line(folder, ours, url)]
    lines += [_lcm_cli_line(ours, url), their_spy_line(folder, ours, group_url(232))]
    lines += foreign_lines(folder / "foreign", group_url(233))
    lines.append(_tests_line())
    for good, numbers in lines:
        say(f"{'ok  ' if good else 'MISS'} {numbers}")
    say(f"     the logs and the screenshots are in {folder}")
    return all(good for good, _ in lines)


def _logger_line(folder: Path, url: str, seed: int) -> Line:
    """Let lcm-logger record the tap; count by ``graphnav info``, and step every stage again."""
    theirs = folder / "theirs.lcmlog"
    command = [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--lcm-url", url + _BUFFER, str(theirs)]
    written = _tapped(folder / "full", "full", seed, url, command, theirs)
    channels = json.loads(_graphnav("info", str(theirs), "--json"))["channels"]
    found = {name: channel["messages"] for name, channel in channels.items()}
    replay = subprocess.run([GRAPHNAV, "replay", theirs], capture_output=True, text=True, check=False)
    carried = _carried(written, found)
    return carried == sum(written.values()) and not replay.returncode, (
        f"the tap by lcm-logger: 'graphnav info' counts {carried} of {sum(written.values())} messages of the run; "
        f"'graphnav replay': {(replay.stdout or replay.stderr).strip().splitlines()[-1]}"
    )


def _record_line(folder: Path, ours: Path, url: str, seed: int) -> Line:
    """Let ``graphnav record`` record the tap."""
    written = _tapped(folder / "thin", "thin", seed, url, [str(GRAPHNAV), "record", url, "-o", str(ours)], ours)
    with Recording(ours) as recording:
        carried = _carried(written, {name: recording.count(name) for name in recording.channels})
    n_written = sum(written.values())
    return carried == n_written, f"the tap by 'graphnav record': {carried} of {n_written} messages of the run"


def _carried(written: Mapping[str, int], found: Mapping[str, int]) -> int:
    """Return how many messages of a run were found; what it published once, the tap repeats."""
    return sum(min(found.get(name, 0), count) for name, count in written.items())


def _tapped(folder: Path, tap: str, seed: int, url: str, recorder: Sequence[str], log: Path) -> dict[str, int]:
    """Drive while a recorder listens; return how many messages the run wrote on each channel."""
    program = subprocess.Popen(recorder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        await_file(log)
        time.sleep(1.0)
        words = [
            "run",
            "corridor_ccw",
            "--seed",
            str(seed),
            "--pace",
            "1",
            "--until",
            str(_DRIVE_S),
            "--record",
            "all",
            "--tap",
            tap,
        ]
        command = [str(GRAPHNAV), *words, "--no-pictures", "-o", str(folder)]
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, "LCM_DEFAULT_URL": url})
        time.sleep(1.0)
    finally:
        end(program)
    with Recording(folder / LOG) as run:
        return {channel: run.count(channel) for channel in run.channels if channel != ABOUT}


def _c_line(folder: Path, log: Path, url: str) -> Line:
    sums = Sums.of_log(log)
    heard = played(c_listener(folder / "c", sums.types, url + _BUFFER), log, url)
    return _compared("C (lcm-gen -c, liblcm of the wheel)", sums, heard, 1.0)


def _java_line(folder: Path, log: Path, url: str) -> Line:
    sums = Sums.of_log(log)
    command = java_listener(folder / "java", sums.types, url)
    if command is None:
        return True, "Java: not tried, there is no JDK"
    return _compared("Java (the jar of 'graphnav types --java')", sums, played(command, log, url), _MIN_JAVA_SHARE)


def _compared(who: str, written: Sums, heard: dict[str, tuple[int, int, int]], min_share: float) -> Line:
    """Compare what a listener decoded of our log, which lcm-logplayer played, with what the log holds."""
    n_written = sum(count for count, _, _ in written.sums.values())
    n_heard = sum(count for count, _, _ in heard.values())
    complete = {channel for channel, sums in written.sums.items() if heard.get(channel) == sums}
    wrong = {
        channel
        for channel in written.sums.keys() - complete
        if heard.get(channel, (0, 0, 0))[0] >= written.sums[channel][0]
    }
    good = not wrong and n_heard >= min_share * n_written
    return good, (
        f"our log by lcm-logplayer, {who}: {n_heard} of {n_written} messages decoded on {len(heard)} channels; sums of "
        f"utime and seq equal on the {len(complete)} channels that came complete, different on {len(wrong)}"
    )


def _lcm_cli_line(log: Path, url: str) -> Line:
    """Let lcm-cli list what we play, and decode five commands by our definitions."""
    if not LCM_CLI.exists():
        return True, "lcm-cli: not tried, it is not installed"
    where = re.fullmatch(r"udpm://([\d.]+):(\d+).*", url)
    assert where is not None
    live = ["--lcm-url", where[1], "--lcm-port", where[2]]
    nothing, command = subprocess.DEVNULL, [str(GRAPHNAV), "play", str(log), "--url", url, "--loop"]
    player = subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)
    try:
        listed = set(_said([str(LCM_CLI), "topic", "list", "-d", "3", *live]).split())
        words = ["topic", "echo", "control.twist", "-n", "5", "-t", "20", "-f", str(ROOT / "lcmtypes")]
        echoed = len(re.findall(r"\bv_mps: -?\d", _said([str(LCM_CLI), *words, *live])))
    finally:
        end(player)
    with Recording(log) as recording:
        channels = set(recording.channels)
    good = channels <= listed and echoed == 5
    return good, f"lcm-cli lists {len(channels & listed)} of {len(channels)} channels, and decodes {echoed} of 5 twists"


def _tests_line() -> Line:
    """Run the tests of the same exchanges."""
    files = [f"tests/lcm/{name}.py" for name in _TESTS]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:randomly", *files]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return not done.returncode, f"pytest {' '.join(_TESTS)}: {done.stdout.strip().splitlines()[-1]}"


def _graphnav(*words: str) -> str:
    return _said([str(GRAPHNAV), *words])


def _said(command: Sequence[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
