"""It replays: recorded drives step again, in lockstep and live, and what was changed is found."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import lcm
import pytest
from bench_replay import PLAY, UNTIL_S, measure
from testbed.drives import GRAPHNAV
from testbed.processes import end, group_url, running
from testbed.rig import Rig

from graphnav import Recording, Twist
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Override
from graphnav.core.run_folder import RunFolder
from graphnav.replay.comparison.result import ReplayResult
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay
from graphnav.watch.loginfo import survey
from tests.targets import Targets

LIMIT = Path(__file__).parent / "stages" / "turn_limit.py"
LIMITED = (
    "--plugin",
    str(LIMIT),
    *("--set", "limit+=limit.turn"),
    *("--set", "limit.in.command=control.twist"),
    *("--set", "guard.in.command=limit.twist"),
)
CONSTANT = "MAX_LEFT_RADPS = 1.2"
CHANGED_SHARE = 0.7
"""Of the fastest turn to the left of the drive."""
DRIVE_S = 15.0
LIVE_S = 15.0
TAPPED_S = 8.0
MAX_RATIO = 0.5


@pytest.mark.parametrize("place", range(3))
def test_replay_in_lockstep(targets: Targets, seeds: range, tmp_path: Path, place: int) -> None:
    """A recorded drive steps again as it was and with changes, which are found."""
    seed = seeds[place % len(seeds)]
    command = [str(GRAPHNAV), "run", "corridor_ccw", "--seed", str(seed), "--until", str(DRIVE_S), "--no-tap"]
    command += ["--no-pictures", "-o", str(tmp_path / "run"), *LIMITED]
    subprocess.run(command, check=True, capture_output=True)
    _check_replays(targets, tmp_path / "run" / RunFolder.LOG, tmp_path)


def test_replay_live(targets: Targets, seeds: range, tmp_path: Path) -> None:
    with Rig(tmp_path, 90, seeds[0], max_drive_s=LIVE_S) as rig:
        rig.navigate(options=[*LIMITED, "--set", "run.record=all"])
        rig.finish()
    _check_replays(targets, tmp_path / "navigation-0" / RunFolder.LOG, tmp_path)


def _check_replays(targets: Targets, log: Path, folder: Path) -> None:
    for good, text in _replays(log, folder):
        targets.check(text, good=good)


def _replays(log: Path, folder: Path) -> Iterator[tuple[bool, str]]:
    """Yield what the replays of a drive found, with nothing and with something changed."""
    again = folder / f"{log.parent.name}-again.lcmlog"
    result = _replay(log, out=again)
    yield result.is_equal and _n_compared(result) > 0, f"nothing swapped: {_told(result)}"
    result = _replay(again)
    yield result.is_equal and not result.lost, f"the log of that replay: {_told(result)}"
    again.unlink()

    result = _replay(log, "plane=plane.affine")
    plane = result.channels["plane.plane"]
    upstream = [name for name in ("flow.flow", "planar.planar") if name in result.channels]
    good = plane.n_differing > 0 and all(result.channels[name].is_equal for name in upstream)
    yield good, f"plane.affine: {_told(result)}; plane.plane up to {plane.max_gap:.3g}; {', '.join(upstream)} equal"

    result = _replay(log, "twin+=plane.affine", "twin.in.flow=flow.flow")
    good = result.is_equal and result.new.get("twin.plane", 0) > 0
    yield good, f"an added plane.affine: {_told(result)}; new, not compared: {dict(result.new)}"

    changed = _changed(log, folder / f"{log.parent.name}-changed")
    result = _replay(log, plugin=changed.plugin)
    found = result.channels["limit.twist"].first
    good = found is not None and found.at_us == changed.first_us and result.channels["control.twist"].is_equal
    expected = f"the first faster turn is at {changed.first_us / 1e6:.2f} s"
    yield good, f"{changed.constant} in the plugin: {_told(result)}; {expected}"

    result = _replay(log, "control.max_speed_mps=0.1")
    good = not result.is_equal and result.channels["steer.steering"].is_equal
    yield good, f"control.max_speed_mps=0.1: {_told(result)}"


def _replay(log: Path, *sets: str, plugin: Path | None = None, out: Path | None = None) -> ReplayResult:
    catalog, plugins = Catalog(), [plugin or LIMIT]
    catalog.add_file(plugins[0])
    with Recording(log) as recording:
        made = graph_to_replay(recording, catalog, overrides=[*map(Override.parse, sets)], plugins=plugins)
        return replay(recording, made, ReplayOptions(), out=out)


class _Changed(NamedTuple):
    """A copy of the plugin with another constant, and when the drive first commanded more than that."""

    plugin: Path
    constant: str
    first_us: int


def _changed(log: Path, folder: Path) -> _Changed:
    with Recording(log) as recording:
        turns = [twist.omega_radps for _, _, twist in recording.messages("limit.twist") if isinstance(twist, Twist)]
        limit_radps = round(CHANGED_SHARE * max(turns), 3)
        first = next(place for place, turn in enumerate(turns) if turn > limit_radps)
        first_us = recording.event_utimes("limit.twist")[first] - recording.begin_us
    folder.mkdir()
    changed = _Changed(folder / LIMIT.name, f"{CONSTANT.partition(' ')[0]} = {limit_radps}", first_us)
    changed.plugin.write_text(LIMIT.read_text().replace(CONSTANT, changed.constant))
    return changed


def _n_compared(result: ReplayResult) -> int:
    return sum(channel.n_compared for channel in result.channels.values())


def _told(result: ReplayResult) -> str:
    n_different = sum(c.n_differing + c.n_missing + c.n_extra for c in result.channels.values())
    text = f"{_n_compared(result)} messages compared, {n_different} differences"
    if result.first is None:
        return text
    name, first = result.first
    channels = sum(not channel.is_equal for channel in result.channels.values())
    return f"{text} on {channels} of {len(result.channels)} channels, the first {name} at {first.at_us / 1e6:.2f} s"


def test_replay_the_tap_by_lcm_logger(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Let lcm-logger record the tap of a run, and read that."""
    url, log = group_url(213) + "&recv_buf_size=4194304", tmp_path / "heard.lcmlog"
    logger = [str(Path(lcm.LCM_BIN_DIR) / "lcm-logger"), "--quiet", "--lcm-url", url, str(log)]
    run = [str(GRAPHNAV), "run", "corridor_ccw", "--seed", str(seeds[0]), "--until", str(TAPPED_S), "--pace", "1"]
    run += ["--tap", "full", "--no-pictures", "-o", str(tmp_path / "run")]
    with running(logger, tmp_path / "logger.txt") as process:
        time.sleep(1)
        subprocess.run(run, check=True, capture_output=True, env={**os.environ, "LCM_DEFAULT_URL": url})
        time.sleep(1)
        end(process)
    info, result = survey(log), _replay(log)
    targets.check(
        f"lcm-logger's recording: info counts {info.n_messages} messages on {len(info.channels)} channels; "
        f"replay: {result.n_ticks} ticks, {_told(result)}",
        good=result.is_equal and _n_compared(result) > 0 and result.n_ticks == round(10 * TAPPED_S) + 1,
    )


def test_replay_is_fast(targets: Targets) -> None:
    found = measure()
    targets.check(
        f"--play {','.join(PLAY)} of a drive of {found['driven, s']:.0f} s (of {UNTIL_S}): {found['replay, s']:.1f} s, "
        f"the run {found['run, s']:.1f} s: ratio {found['ratio']:.2f}, at most {MAX_RATIO}",
        good=found["ratio"] <= MAX_RATIO,
    )
