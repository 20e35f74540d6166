"""Live drives with a process for each stage: arrivals, processes killed and suspended, latency, load, replays."""

from __future__ import annotations

import os
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import drives_forward, hear, running
from testbed.rig import Rig, summary_of

from graphnav import Recording, Status
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import RunningRun
from graphnav.processes.running_runs import processes_of
from tests.processes.conftest import is_alive, wait_until
from tests.targets import Targets

from .harms import STANDS_MPS, WAIT_S, Harm, harm_of, states_of

MIN_SHARE = 0.9
N_SEEDS = 4
STAGES = tuple(node.name for node in load_graph("navigate_live", Catalog()).nodes)
POLICY = "restart: on_failure, restart_delay_s: 0.1, max_restarts: 100"
STOP_S = 0.75
"""Time until the robot brakes: the guard acts at once or within the age that it allows, the motor process after 0.5 s
of silence, and the machine may be busy.
"""
BACK_S = 2.0
SUSPENDED_S = 3.0
OVERTAKEN = "flow.image"
MAX_PENDING = 2
"""A frame in a step that was broken off at the end of the run, and one that waited for it."""
CLOCKED = "guard"
"""The stage that fires by its own timer, too."""
PER_DRIVE = 14
"""Processes that are killed in one drive, at most."""
MAX_PAUSE_S = 6.0
"""Between two kills, at most; less than it takes to come back is drawn, too."""
KILLED_DRIVE_S = 400.0
STEADY_S, RATE_HZ = 60.0, 10
FROM_S = 5.0
"""Frames are counted from here on: before, odometry may not have come yet."""
BURN = "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\nwhile True: pass"


class Drive(NamedTuple):
    """A drive in which every stage was harmed once."""

    outcome: str
    has_contact: bool
    harms: Sequence[Harm]
    back_s: Sequence[float]
    restarts: int
    n_left: int
    """Processes that were left."""
    n_more: int
    """Descriptors that the run had more at the end of the drive than when the first process was back."""


def _graph(folder: Path) -> Path:
    """Write the graph whose stages live in processes that are started again."""
    path = folder / "watched.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    parts = ", ".join(f"{name}: {{stages: [{name}], {POLICY}}}" for name in STAGES)
    path.write_text(f"extends: navigate_live\ndeploy: {{{parts}}}\n")
    return path


def _pids(folder: Path) -> dict[str, int]:
    """Return the processes of the stages of the run in a folder."""
    runs = [run for run in RunningRun.all() if run.folder == folder]
    return {process.name: process.pid for run in runs for process in processes_of(run)}


def _n_descriptors(pid: int) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))


@pytest.fixture
def sockets(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return the folder in which runs make those of their sockets."""
    with tempfile.TemporaryDirectory() as folder:
        monkeypatch.setenv("TMPDIR", folder)
        yield Path(folder)


def test_a_process_for_each_stage_arrives(targets: Targets, seeds: range, jobs: int, tmp_path: Path) -> None:
    """Arrivals, overtaken frames and latency, and what a replay of each log differs in."""

    def drive(seed: int) -> tuple[str, dict[str, Any], str]:
        folder = tmp_path / f"{seed}"
        with Rig(folder, 1 + seed % 100, seed) as rig:
            rig.navigate(options=("--processes", "--set", "run.record=replayable"))
            robot, graph = rig.finish()
        command = [str(GRAPHNAV), "replay", str(folder / "navigation-0")]
        replayed = subprocess.run(command, capture_output=True, text=True, check=False)
        return robot["outcome"], graph["live"], replayed.stdout if replayed.returncode == 0 else replayed.stderr

    with ThreadPoolExecutor(jobs) as pool:
        drives = list(pool.map(drive, seeds[:N_SEEDS]))
    goals = sum(outcome == "goal" for outcome, *_ in drives)
    frames = sum(one["accepted"] for _, live, _ in drives for one in live["inputs"] if one["name"] == "camera.image")
    overtaken = sum(one["overtaken"] for _, live, _ in drives for one in live["edges"] if one["name"] == OVERTAKEN)
    p50_ms = statistics.median(live["outputs"][0]["latency_p50_ms"] for _, live, _ in drives)
    targets.check(
        f"{goals} of {len(drives)} arrive; {overtaken} of {frames} frames overtaken; median of image to command "
        f"{p50_ms:.1f} ms",
        good=goals >= MIN_SHARE * len(drives) and overtaken <= 0.01 * frames,
    )
    equal = [said for *_, said in drives if "no differences: " in said]
    targets.check(f"{len(equal)} of {len(drives)} logs replay without a difference", good=len(equal) == len(drives))
    for *_, said in drives:
        if said not in equal:
            targets.say(said)


@pytest.mark.parametrize("kind", ["killed", "suspended"])
def test_each_process_is_harmed_once(
    targets: Targets, seeds: range, jobs: int, tmp_path: Path, sockets: Path, kind: str
) -> None:
    with ThreadPoolExecutor(jobs) as pool:
        drives = list(pool.map(lambda seed: _harmed(tmp_path / f"{seed}", seed, kind), seeds[:N_SEEDS]))
    harms = [harm for drive in drives for harm in drive.harms]
    n_goals, n_contacts = (
        sum(column) for column in zip(*((d.outcome == "goal", d.has_contact) for d in drives), strict=True)
    )
    n_left, n_more = (sum(column) for column in zip(*((d.n_left, d.n_more) for d in drives), strict=True))
    n_sockets = len(list(sockets.glob("graphnav-*")))
    worst = {
        name: [max(times) for times in zip(*(one[1:] for one in harms if one.stage == name), strict=True)]
        for name in STAGES
    }
    by_stage = "; ".join(f"{name} {brakes_s:.2f}, {on_s:.2f}" for name, (brakes_s, on_s) in worst.items())
    is_fine = n_goals == len(drives) and not (n_contacts or n_left or n_sockets) and n_more <= 0
    is_fine &= max(h.brakes_s for h in harms) <= STOP_S
    text = f"{len(harms)} {kind}: {n_goals} of {len(drives)} arrive, {n_contacts} contacts; left behind: "
    text += f"{n_left} processes, {n_sockets} sockets, {n_more} descriptors"
    if kind == "killed":
        back_s = sorted(s for drive in drives for s in drive.back_s)
        n_restarts = sum(drive.restarts for drive in drives)
        text += f"; {n_restarts} started again, back after {statistics.median(back_s):.2f} s, worst {back_s[-1]:.2f}"
        is_fine &= n_restarts == len(harms) == len(back_s) and back_s[-1] <= BACK_S
    targets.check(text, good=is_fine)
    targets.say(f"  worst time until the robot brakes, and until it drives on, s: {by_stage}")


def _harmed(folder: Path, seed: int, kind: str) -> Drive:
    begun: dict[str, float] = {}
    with Rig(folder, 1 + seed % 100, seed, ("--set", "robot.state_hz=100")) as rig:
        run = folder / "navigation-0"
        navigation = rig.navigate(str(_graph(folder)))
        _await_speed(rig)
        n_descriptors: list[int] = []
        pids = set(_pids(run).values())
        for stage in STAGES:
            pid = _pids(run)[stage]
            begun[stage] = time.time()
            if kind == "killed":
                os.kill(pid, signal.SIGKILL)
                wait_until(partial(_is_back, run, stage, pid))
            else:
                os.kill(pid, signal.SIGSTOP)
                time.sleep(SUSPENDED_S)
                os.kill(pid, signal.SIGCONT)
            _await_speed(rig)
            pids |= set(_pids(run).values())
            n_descriptors.append(_n_descriptors(navigation.pid))
        robot, graph = rig.finish()
    n_left, n_more = sum(map(is_alive, pids)), n_descriptors[-1] - n_descriptors[0]
    said = run.with_suffix(".txt").read_text()
    back_s = [float(s) for s in re.findall(r"is back after ([0-9.]+) s", said)]
    processes: Mapping[str, Any] = graph["processes"]
    restarts = sum(told["restarts"] for told in processes.values())
    states = states_of(folder / "robot")
    has_contact = any(state.contact for _, state in states)
    lasting_s = SUSPENDED_S if kind == "suspended" else 0.0
    harms = [harm_of(stage, begin_s, states, lasting_s) for stage, begin_s in begun.items()]
    return Drive(robot["outcome"], has_contact, harms, back_s, restarts, n_left, n_more)


def _await_speed(rig: Rig) -> None:
    """Wait until the robot is told to drive, and has the time to become fast."""
    hear(rig.graph_url, "BASE_CMD", drives_forward)
    time.sleep(1.0)


def _is_back(run: Path, stage: str, pid: int) -> bool:
    return _pids(run).get(stage, pid) != pid


class Killed(NamedTuple):
    """A drive in which stages were killed at random moments."""

    outcome: str
    has_contact: bool
    n_kills: int
    n_ended: int
    """Processes of which the run tells that they ended before it did."""
    left: Sequence[str]
    """Stages that were to be killed when the drive ended."""
    n_left: int
    n_more: int


def test_each_stage_is_killed_many_times_at_random_moments(
    targets: Targets, seeds: range, jobs: int, kills: int, tmp_path: Path, sockets: Path
) -> None:
    """Drives, until each stage was killed ``--kills`` times; some while they are being started again."""
    left = [stage for stage in STAGES for _ in range(kills)]
    random.Random(seeds[0]).shuffle(left)
    numbers = count(seeds[0])
    drives = list[Killed]()
    while left:
        parts = [(next(numbers), left[k : k + PER_DRIVE]) for k in range(0, len(left), PER_DRIVE)]
        with ThreadPoolExecutor(jobs) as pool:
            made = list(pool.map(lambda part: _killed(tmp_path / f"{part[0]}", *part), parts))
        drives += made
        left = [stage for drive in made for stage in drive.left]
    n_goals, n_contacts = (
        sum(column) for column in zip(*((d.outcome == "goal", d.has_contact) for d in drives), strict=True)
    )
    n_kills, n_ended, n_left, n_more = (
        sum(column)
        for column in zip(*((d.n_kills, d.n_ended, d.n_left, max(0, d.n_more)) for d in drives), strict=True)
    )
    n_sockets = len(list(sockets.glob("graphnav-*")))
    targets.check(
        f"{n_kills} kills, {kills} of each of {len(STAGES)} stages, in {len(drives)} drives: {n_goals} arrive, "
        f"{n_contacts} contacts; {n_ended} ends told; left behind: {n_left} processes, {n_sockets} sockets, {n_more} "
        "descriptors",
        good=n_goals >= MIN_SHARE * len(drives)
        and n_kills == n_ended == kills * len(STAGES)
        and not (n_contacts or n_left or n_sockets or n_more),
    )


def _killed(folder: Path, seed: int, stages: Sequence[str]) -> Killed:
    """Drive, and kill stages one after another."""
    drawn, left = random.Random(seed), list(stages)
    robot_options = ("--set", "robot.state_hz=100")
    with Rig(folder, 1 + seed % 100, seed, robot_options, KILLED_DRIVE_S) as rig:
        run = folder / "navigation-0"
        navigation = rig.navigate(str(_graph(folder)))
        hear(rig.graph_url, "BASE_CMD", drives_forward)
        pids = set(_pids(run).values())
        n_descriptors = _n_descriptors(navigation.pid)
        while left and rig.is_driving:
            time.sleep(drawn.uniform(0.0, MAX_PAUSE_S))
            found = _pids(run)
            pids |= set(found.values())
            if left[-1] in found and rig.is_driving:
                os.kill(found[left.pop()], signal.SIGKILL)
        wait_until(lambda: _pids(run).keys() == set(STAGES))
        pids |= set(_pids(run).values())
        n_more = _n_more(navigation.pid, n_descriptors)
        robot, graph = rig.finish(KILLED_DRIVE_S + 30)
    n_ended = sum(len(told["ended"]) for told in graph["processes"].values())
    has_contact = any(state.contact for _, state in states_of(folder / "robot"))
    n_left = sum(map(is_alive, pids))
    return Killed(robot["outcome"], has_contact, len(stages) - len(left), n_ended, left, n_left, n_more)


def _n_more(pid: int, n_before: int) -> int:
    """Return how many descriptors a process has more than before, once those of a start are closed."""
    end_s = time.monotonic() + WAIT_S
    while (n_more := _n_descriptors(pid) - n_before) > 0 and time.monotonic() < end_s:
        time.sleep(0.1)
    return n_more


def test_no_tick_is_missed_on_an_idle_machine(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """A minute at 10 Hz: frames that came, were lost and overtaken, and the steps of each stage of the chain."""
    with Rig(tmp_path, 212, seeds[0], ("--set", "robot.ends=false"), STEADY_S + 60.0) as rig:
        navigation = rig.navigate(options=("--processes", "--until", str(STEADY_S)))
        navigation.wait(STEADY_S + 120.0)
    summary = summary_of(tmp_path / "navigation-0")
    with Recording(tmp_path / "navigation-0" / RunFolder.LOG) as log:
        statuses = [m for _, _, m in log.messages(Status.CHANNEL) if isinstance(m, Status) and m.run_s >= FROM_S]
    first, last = statuses[0], statuses[-1]
    frames = _accepted(last) - _accepted(first)
    due = round(RATE_HZ * (last.run_s - first.run_s))
    steps = {name: n - _steps(first)[name] for name, n in _steps(last).items() if name != CLOCKED}
    missed = {name: frames - n for name, n in steps.items() if abs(frames - n) > 1}  # one may be on its way
    overtaken = {one["name"]: one["overtaken"] for one in last.edges if one["overtaken"]}
    lost = next(one["lost"] for one in last.inputs if one["name"] == "camera.image")
    targets.check(
        f"{last.run_s - first.run_s:.1f} s at {RATE_HZ} Hz in {len(last.processes)} processes: {frames} frames came, "
        f"{due} were due, {lost} lost; steps missed: {missed or 'none'}; overtaken: {overtaken or 'none'}",
        good=abs(frames - due) <= 1 and not (lost or missed or overtaken) and summary["outcome"] == "timeout",
    )


def _accepted(status: Status) -> int:
    return int(next(one["accepted"] for one in status.inputs if one["name"] == "camera.image"))


def _steps(status: Status) -> dict[str, int]:
    return {one["name"]: int(one["steps"]) for one in status.stages}


def test_a_core_is_burnt(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Drives while another program takes all that it gets of one core: they arrive, and each frame is accounted for."""
    outcomes, came, stepped, overtaken = list[str](), 0, 0, 0
    is_counted = True
    with running([sys.executable, "-c", BURN], tmp_path / "burn.txt"):
        for seed in seeds[:N_SEEDS]:
            folder = tmp_path / f"{seed}"
            with Rig(folder, 1 + seed % 100, seed) as rig:
                rig.navigate(options=("--processes",))
                robot, graph = rig.finish()
            frames = next(one["accepted"] for one in graph["live"]["inputs"] if one["name"] == "camera.image")
            dropped = next(one["overtaken"] for one in graph["live"]["edges"] if one["name"] == OVERTAKEN)
            steps = graph["stages"]["flow"]["steps"]
            outcomes.append(robot["outcome"])
            came, stepped, overtaken = came + frames, stepped + steps, overtaken + dropped
            is_counted &= 0 <= frames - steps - dropped <= MAX_PENDING
    goals = outcomes.count("goal")
    targets.check(
        f"with a core burnt {goals} of {len(outcomes)} arrive; of {came} frames {stepped} were used and {overtaken} "
        f"overtaken, {came - stepped - overtaken} were pending at the ends",
        good=goals >= MIN_SHARE * len(outcomes) and is_counted,
    )


def test_a_stage_that_ends_at_each_start_is_given_up(targets: Targets, tmp_path: Path) -> None:
    """The robot never moves, and the run says why with status 1."""
    plugin = tmp_path / "ends.py"
    plugin.write_text(
        "import os\nfrom graphnav import Plane, Stage, hookimpl\nFAMILY = 'ends'\n\n\nclass Ends(Stage):\n"
        "    def reset(self, seed: int) -> None:\n        os._exit(3)\n\n"
        "    def step(self, plane: Plane) -> Plane:\n        return plane\n\n\n"
        "@hookimpl\ndef graphnav_stages():\n    return [Ends]\n"
    )
    graph = tmp_path / "ends.yaml"
    part = "ends: {stages: [ends], restart: on_failure, max_restarts: 2, restart_delay_s: 0.1}"
    graph.write_text(
        "extends: navigate_live\nplugins: [ends.py]\n"
        "stages: {ends: {use: ends.ends, in: {plane: plane.plane}}, steer: {in: {plane: ends.plane}}}\n"
        f"deploy: {{{part}}}\n"
    )
    with Rig(tmp_path, 7, 1000, ("--set", "robot.state_hz=100"), 40.0) as rig:
        navigation = rig.navigate(str(graph))
        status = navigation.wait(60)
        rig.robot.send_signal(signal.SIGINT)
        rig.robot.wait(30)
    said = (tmp_path / "navigation-0.txt").read_text()
    moved = max(abs(state.v_mps) for _, state in states_of(tmp_path / "robot"))
    is_told = "its process 'ends' ended with exit status 3, and is given up after 2 restarts in 60 s" in said
    text = f"ends at each start: exit status {status}, {'told' if is_told else 'not told'}, fastest {moved:.2f} m/s"
    targets.check(text, good=status == 1 and is_told and moved < STANDS_MPS)
