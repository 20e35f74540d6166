"""Runs that are changed all the time: no stamp is lost, bad requests are refused, and a replay repeats all of it."""

from __future__ import annotations

import itertools
import json
import os
import random
import signal
import statistics
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.graph import load_graph
from graphnav.core.messages import Changed
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Answer, Request, RunningRun, ask
from tests.processes.conftest import LATE_ANSWERS, Runs, request, restarted, wait_until
from tests.targets import Targets

N_SWAPS, N_SETTINGS, N_BAD = 50, 200, 50
PERIOD_US = 100_000
N_TRIALS, N_CHANGES, N_KILLS, KILLED_UNTIL_S = 10, 10, 4, 4.0
GRAPH = """
extends: corridor_ccw
run: {record: replayable, until_s: 600}
stages:
  guard: {in: {deviation: null}}
  control: {with: {max_speed_mps: 0.005}}
queues: {flow.image: {keep: all}}
"""
"""The robot crawls, so that it touches nothing; live, every image is used, however busy the machine is."""
USES = {
    "flow": ("flow.dis", "flow.farneback", "flow.plain_lucas_kanade", "flow.lucas_kanade"),
    "plane": ("plane.affine", "plane.homography", "plane.row_median", "plane.ica"),
    "steer": ("steer.balance", "steer.pca"),
}
SETTINGS = (
    "control.max_speed_mps=0.00{}",
    "control.max_turn_radps=1.{}",
    "steer.goal_weight=0.{}",
    "guard.max_obstacle_ratio=0.9{}",
    "planar.model=models/downward_160x120.lcmlog",
)
BAD = (
    ("plane=plane.afine", "family 'plane' has no stage 'afine'"),
    ("control.max_speed_mps=-1", "'max_speed_mps' is -1, but must be"),
    ("plan.rule=otsu", "there is no stage 'plan'"),
    ("robot.rate_hz=5", "is a source"),
    ("plane=steer.pca", "needs Plane in place of plane.plane"),
)


@pytest.mark.parametrize("where", [(), ("--processes",)], ids=["in-one", "apart"])
@pytest.mark.parametrize("mode", ["--live", "--pace=2"], ids=["live", "lockstep"])
def test_changes_all_the_time(
    targets: Targets, tmp_path: Path, mode: str, where: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run"
    (tmp_path / "crawl.yaml").write_text(GRAPH)
    words = ["run", str(tmp_path / "crawl.yaml"), mode, *where, "-o", str(folder), "--no-tap", "--no-pictures", "-d"]
    subprocess.run([sys.executable, "-m", "graphnav", *words], check=True, capture_output=True)
    wait_until(lambda: any(run.folder == folder for run in RunningRun.all()))
    run = next(run for run in RunningRun.all() if run.folder == folder)
    try:
        took_s = _changed(run)
        assert main(["stop", run.run_id]) == 0
    finally:
        if run.is_running:
            os.kill(run.pid, signal.SIGKILL)
    summary = json.loads((folder / RunFolder.SUMMARY).read_text())
    n_bad_refused = round(took_s.pop("bad")[0])
    median_s, longest_s = (f(took_s["swap"] + took_s["set"]) for f in (statistics.median, max))
    text = f"{' '.join((mode, *where))}, {summary['sim_s']:.0f} s, {N_SWAPS} swaps and {N_SETTINGS} settings"
    targets.say(f"{text}: {median_s * 1e3:.0f} ms from request to take-over, longest {longest_s * 1e3:.0f} ms")
    targets.check(f"  {n_bad_refused} of {N_BAD} bad ones refused with their message", good=n_bad_refused == N_BAD)
    targets.check(f"  outcome {summary['outcome']} {summary['failure']}", good=summary["outcome"] == "stopped")
    with Recording(folder / RunFolder.LOG) as recording:
        stamps = [utime for utime, _, _ in recording.messages("robot.image")]
        n_changes = recording.count(Changed.CHANNEL)
        changes = [one for _, _, one in recording.messages(Changed.CHANNEL) if isinstance(one, Changed)]
    n_flows = sum(one.stage == "flow" for one in changes)
    steps = {name: stage["steps"] for name, stage in summary["stages"].items()}
    gaps = sum(after - before > 1.5 * PERIOD_US for before, after in itertools.pairwise(stamps))
    targets.check(f"  {gaps} gaps in {len(stamps)} stamps of the source", good=not gaps)
    lost = len(stamps) - steps["flow"]
    targets.check(f"  {lost} stamps without a step of the flow", good=lost in {0, 1})
    expected = steps["flow"] - n_flows - 1
    missing = {name: expected - steps[name] for name in ("plane", "steer", "control")}
    text = f"  {n_flows} frames without flow, since it was restarted; beyond these {missing} steps are missing"
    targets.check(text, good=all(abs(count) <= 1 for count in missing.values()))
    capsys.readouterr()
    status = main(["replay", str(folder)])
    told = capsys.readouterr().out.strip().splitlines()[-1]
    targets.check(f"  {n_changes} changes in the log; replay: {told}", good=status == 0 and "no differences" in told)
    assert n_changes == N_SWAPS + N_SETTINGS == len(summary["changes"])


def test_changed_processes_that_are_killed_give_the_bytes_of_one(targets: Targets, tmp_path: Path, runs: Runs) -> None:
    """Swaps, settings and kills at random stamps; the run in one process gets the changes that were made."""
    graph = load_graph("corridor_ccw", Catalog())
    graph = replace(graph, run=replace(graph.run, until_s=KILLED_UNTIL_S))
    many = restarted(replace(graph, plugins=(LATE_ANSWERS,)).with_processes())
    n_equal, n_made, n_refused, n_ended = 0, 0, 0, 0
    for k in range(N_TRIALS):
        drawn = random.Random(k)
        asked = {drawn.uniform(0.1, KILLED_UNTIL_S): [request(_drawn_words(drawn))] for _ in range(N_CHANGES)}
        kills = {drawn.uniform(0.1, KILLED_UNTIL_S): drawn.choice(list(many.deploy)) for _ in range(N_KILLS)}
        apart = runs(many, kills, changes=asked)
        refused = [answer for answer in apart.answers if answer.at_s is None]
        made: dict[float, list[Request]] = {}
        for one in apart.summary.changes:
            made.setdefault(one["at_s"], []).append(request(*one["words"]))
        alone = runs(graph, changes=made)
        n_equal += apart.log == alone.log and apart.summary.scores == alone.summary.scores
        n_made, n_refused = n_made + len(apart.summary.changes), n_refused + len(refused)
        n_ended += sum(len(told["ended"]) for told in (apart.summary.processes or {}).values())
    told = f"{n_made} changes made, {n_refused} refused since a process ended meanwhile, {n_ended} processes killed"
    targets.check(f"corridor_ccw, {told}: {n_equal} of {N_TRIALS} logs equal", good=n_equal == N_TRIALS and n_ended > 0)


def _drawn_words(drawn: random.Random) -> str:
    """Return a swap or a setting."""
    if drawn.random() < 0.5:
        stage = drawn.choice(list(USES))
        return f"{stage}={drawn.choice(USES[stage])}"
    return drawn.choice(SETTINGS).format(drawn.randint(1, 8))


def _changed(run: RunningRun) -> dict[str, list[float]]:
    """Return how long swaps and settings took, s, and the number of bad requests that were refused."""
    drawn = random.Random(0)
    uses = {stage: itertools.cycle(uses) for stage, uses in USES.items()}
    stages = itertools.cycle(USES)
    work = ["swap"] * N_SWAPS + ["set"] * N_SETTINGS + ["bad"] * N_BAD
    drawn.shuffle(work)
    took_s: dict[str, list[float]] = {"swap": [], "set": [], "bad": [0.0]}
    for k, kind in enumerate(work):
        begin_s = time.monotonic()
        if kind == "bad":
            words, told = BAD[k % len(BAD)]
            problems = _asked(run, words).problems
            took_s["bad"][0] += bool(problems) and told in problems[0].what
            continue
        stage = next(stages) if kind == "swap" else ""
        words = f"{stage}={next(uses[stage])}" if stage else SETTINGS[k % len(SETTINGS)].format(drawn.randint(1, 8))
        answer = _asked(run, words)
        assert answer.at_s is not None, (words, answer)
        took_s[kind].append(time.monotonic() - begin_s)
    return took_s


def _asked(run: RunningRun, words: str) -> Answer:
    return ask(run, Request((words,), "", os.getcwd()))
