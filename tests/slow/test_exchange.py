"""Exchange logs and traffic both ways between graphnav and other programs: LCM's own, C, Java, lcm-cli."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sysconfig
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import lcm
import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import await_file, end, group_url

from graphnav import Recording
from graphnav.core.messages import About
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

from .foreign_listeners import Sums, c_listener, java_listener, played

ROOT = Path(__file__).resolve().parents[2]
LCM_CLI = Path(sysconfig.get_path("scripts")) / "lcm"
_BUFFER = "&recv_buf_size=2097152"
_DRIVE_S = 15
_MIN_JAVA_SHARE = 0.99
"""Java programs have the receive buffer of a stock machine, whatever their URL says."""
URL = group_url(231)

Recorded = tuple[Path, dict[str, int]]


def test_exchange_the_tap_by_lcm_logger(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """The record of a run by lcm-logger is counted by ``graphnav info``, and every stage steps again."""
    theirs = tmp_path / "theirs.lcmlog"
    command = [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--lcm-url", URL + _BUFFER, str(theirs)]
    written = _tapped(tmp_path / "full", "full", seeds[0], command, theirs)
    channels = json.loads(_said([str(GRAPHNAV), "info", str(theirs), "--json"]))["channels"]
    found = {name: channel["messages"] for name, channel in channels.items()}
    replay = subprocess.run([GRAPHNAV, "replay", theirs], capture_output=True, text=True, check=False)
    carried = _carried(written, found)
    text = f"'graphnav info' counts {carried} of {sum(written.values())} messages of the run; 'graphnav replay': "
    text += (replay.stdout or replay.stderr).strip().splitlines()[-1]
    targets.check(text, good=carried == sum(written.values()) and not replay.returncode)


@pytest.fixture(scope="module")
def recorded(seeds: range, tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Return what ``graphnav record`` heard of a run's tap, and how many messages the run wrote on each channel."""
    folder = tmp_path_factory.mktemp("recorded")
    ours = folder / "ours.lcmlog"
    return ours, _tapped(folder / "thin", "thin", seeds[0], [str(GRAPHNAV), "record", URL, "-o", str(ours)], ours)


def test_exchange_the_tap_by_record(targets: Targets, recorded: Recorded) -> None:
    log, written = recorded
    with Recording(log) as recording:
        carried = _carried(written, {name: recording.count(name) for name in recording.channels})
    n_written = sum(written.values())
    targets.check(f"'graphnav record': {carried} of {n_written} messages of the run", good=carried == n_written)


def _carried(written: Mapping[str, int], found: Mapping[str, int]) -> int:
    """Return how many messages of a run were found; what it published once, the tap repeats."""
    return sum(min(found.get(name, 0), count) for name, count in written.items())


def _tapped(folder: Path, tap: str, seed: int, recorder: Sequence[str], log: Path) -> dict[str, int]:
    """Drive while a recorder listens; return how many messages the run wrote on each channel."""
    program = subprocess.Popen(recorder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        await_file(log)
        time.sleep(1.0)
        words = ["run", "corridor_ccw", "--seed", str(seed), "--pace", "1", "--until", str(_DRIVE_S), "--record", "all"]
        command = [str(GRAPHNAV), *words, "--tap", tap, "--no-pictures", "-o", str(folder)]
        subprocess.run(command, check=True, capture_output=True, env={**os.environ, "LCM_DEFAULT_URL": URL})
        time.sleep(1.0)
    finally:
        end(program)
    with Recording(folder / RunFolder.LOG) as run:
        return {channel: run.count(channel) for channel in run.channels if channel != About.CHANNEL}


def test_exchange_our_log_in_c(targets: Targets, recorded: Recorded, tmp_path: Path) -> None:
    """By lcm-logplayer to a program of lcm-gen -c and the liblcm of the wheel."""
    sums = Sums.of_log(recorded[0])
    heard = played(c_listener(tmp_path / "c", sums.types, URL + _BUFFER), recorded[0], URL)
    _compare(targets, sums, heard, 1.0)


def test_exchange_our_log_in_java(targets: Targets, recorded: Recorded, tmp_path: Path) -> None:
    """By lcm-logplayer to a program with the jar of ``graphnav types --java``."""
    sums = Sums.of_log(recorded[0])
    command = java_listener(tmp_path / "java", sums.types, URL)
    if command is None:
        pytest.skip("there is no JDK")
    _compare(targets, sums, played(command, recorded[0], URL), _MIN_JAVA_SHARE)


def _compare(targets: Targets, written: Sums, heard: dict[str, tuple[int, int, int]], min_share: float) -> None:
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
    targets.check(
        f"{n_heard} of {n_written} messages decoded on {len(heard)} channels; sums of utime and seq equal on the "
        f"{len(complete)} channels that came complete, different on {len(wrong)}",
        good=good,
    )


@pytest.mark.skipif(not LCM_CLI.exists(), reason="lcm-cli is not installed")
def test_exchange_with_lcm_cli(targets: Targets, recorded: Recorded) -> None:
    """It lists what we play, and decodes five commands by our definitions."""
    log, _ = recorded
    where = re.fullmatch(r"udpm://([\d.]+):(\d+).*", URL)
    assert where is not None
    live = ["--lcm-url", where[1], "--lcm-port", where[2]]
    nothing, command = subprocess.DEVNULL, [str(GRAPHNAV), "play", str(log), "--url", URL, "--loop"]
    player = subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)
    try:
        listed = set(_said([str(LCM_CLI), "topic", "list", "-d", "3", *live]).split())
        words = ["topic", "echo", "control.twist", "-n", "5", "-t", "20", "-f", str(ROOT / "lcmtypes")]
        echoed = len(re.findall(r"\bv_mps: -?\d", _said([str(LCM_CLI), *words, *live])))
    finally:
        end(player)
    with Recording(log) as recording:
        channels = set(recording.channels)
    text = f"lcm-cli lists {len(channels & listed)} of {len(channels)} channels, and decodes {echoed} of 5 twists"
    targets.check(text, good=channels <= listed and echoed == 5)


def _said(command: Sequence[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
