"""Live runs whose stages live in processes of their own: what arrives, what a stop or an end of one does, replays."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path

import pytest

from graphnav import Odometry, Recording, Status
from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Override
from graphnav.core.messages import Goal
from graphnav.core.trust import Trust
from graphnav.processes.supervisor import Supervisor
from graphnav.replay.log.log_graph import graph_to_replay
from graphnav.replay.replay import ReplayOptions, replay
from tests.live.conftest import EVERY_KIND, Live, Outside
from tests.live.conftest import STAGES as PROBES
from tests.processes.conftest import STAGES, is_alive, wait_until

LEVEL = 7
"""The gray level that the camera shows, which is the speed, m/s."""
CHAIN = """
run: {{until_s: 60, record: replayable}}
inputs: {{camera.image: {{channel: CAMERA, type: graphnav_lcm.image_t}}}}
stages:
  see:   {{use: probe.brightness, in: {{image: camera.image}}}}
  relay: {{use: steps.pass, in: {{one: see.twist}}, with: {relay}}}
  guard: {{use: probe.pass, every_ms: 20, in: {{command: relay.twist, image: camera.image}}}}
{more}
outputs: {{guard.twist: {{channel: SPEED, motor: true}}}}
deploy:
  eyes: {{stages: [see], {policy}}}
  middle: {{stages: [relay], {policy}}}
  {guard}
"""
SLOW = "  slow: {use: probe.brightness, with: {dawdle_s: 0.05}, in: {image: camera.image}}"
FAST = "restart: on_failure, restart_delay_s: 0.01, max_restarts: 3"
GUARD = "last: {stages: [guard], restart: always, restart_delay_s: 2}"
"""Back only after the motors have stopped, which takes half a second."""


@pytest.fixture
def plugins() -> Sequence[Path]:
    """Return the stages that count, too."""
    return (STAGES,)


def chain(policy: str = FAST, relay: str = "{}", guard: str = "", more: str = "") -> str:
    """Return a graph from a camera to motors, with ``more`` stages."""
    return CHAIN.format(policy=policy, relay=relay, guard=guard, more=more)


class Driven:
    """A live run of a graph, a camera at 50 Hz in front of it, and the commands behind it."""

    def __init__(self, begin: Callable[..., Live], make: Callable[..., Outside], text: str) -> None:
        self.supervisors: list[Supervisor] = []
        self.outside = make("SPEED")
        self.looks: list[float] = []
        """Times of the run's statuses."""
        self.errors: list[GraphnavError] = []
        self.run = begin(
            text, supervised=self.supervisors.append, on_time=self.looks.append, on_failure=self.errors.append
        )

    @property
    def speeds(self) -> list[float]:
        """The commands so far, m/s."""
        return [v for _, v in self.outside.speeds("SPEED")]

    def show_until(self, holds: Callable[[], bool]) -> None:
        """Show the camera's picture again and again until something holds."""

        def shown() -> bool:
            self.outside.show("CAMERA", LEVEL)
            time.sleep(0.015)
            return holds()

        self.outside.wait_for(shown)

    def drive(self) -> None:
        """Show pictures until a new command drives."""
        n_heard = len(self.speeds)
        self.show_until(lambda: LEVEL in self.speeds[n_heard:])

    def stop(self) -> None:
        """Show pictures until a new command stops."""
        n_heard = len(self.speeds)
        self.show_until(lambda: 0.0 in self.speeds[n_heard:])

    def send(self, name: str, number: int) -> int:
        """Send a signal to a process of the run; return its number."""
        pid = self.supervisors[0].pid_of(name)
        assert pid is not None
        os.kill(pid, number)
        return pid


@pytest.fixture
def driven(live: Callable[..., Live], outside: Callable[..., Outside]) -> Callable[[str], Driven]:
    """Return a function that begins a run and drives."""

    def begin(text: str) -> Driven:
        made = Driven(live, outside, text)
        made.drive()
        return made

    return begin


@contextmanager
def suspended(one: Driven, name: str) -> Iterator[None]:
    """Suspend a process of a run while entered."""
    one.send(name, signal.SIGSTOP)
    try:
        yield
    finally:
        one.send(name, signal.SIGCONT)


def test_every_kind_of_stage_works_in_a_process_of_its_own_and_is_replayed(
    live: Callable[..., Live],
    outside: Callable[..., Outside],
) -> None:
    program = outside("SPEED")
    run = live(EVERY_KIND, processes=True)
    program.wait_for(lambda: bool(program.of("SPEED")))
    for level in range(60):
        for _ in range(3):
            program.say("ODOMETRY", Odometry(x_m=0.1 * level, y_m=0.0, yaw_rad=0.0, v_mps=1.0, omega_radps=0.0))
        program.show("CAMERA", level)
        time.sleep(0.015)
    program.wait_for(lambda: any(v == 2 * level for _, v in program.speeds("SPEED")))  # both of the last picture
    summary, log = run.stop()
    with log:
        assert summary.outcome == "stopped"
        assert {name for name, told in (summary.processes or {}).items() if not told["ended"]} == set(summary.stages)
        overtaken = {edge["name"]: edge["overtaken"] for edge in (summary.live or {})["edges"]}
        assert overtaken["slow.image"] > 0
        slow, both = log.utimes("slow.twist"), log.utimes("both.twist")
        assert slow[-1] == log.utimes("camera.image")[-1]
        assert set(both) <= set(slow)
        ticks = [goal for _, _, goal in log.messages("tick.goal") if isinstance(goal, Goal)]
        assert [goal.bearing_rad for goal in ticks] == list(range(1, len(ticks) + 1))
        assert min(goal.distance_m for goal in ticks) < 1.0
        gathered = [goal.bearing_rad for _, _, goal in log.messages("gather.goal") if isinstance(goal, Goal)]
        assert sum(gathered) <= log.count("base.odometry")
        assert max(gathered) >= 3
    with Recording(run.folder / "run.lcmlog") as recording:
        made = graph_to_replay(recording, Catalog(Trust(runs_all=True)), overrides=[Override.parse("slow.dawdle_s=0")])
        result = replay(recording, made, ReplayOptions())
    assert result.is_equal, result
    assert result.n_ticks == sum(did.steps for name, did in summary.stages.items() if name != "tick")


def test_a_stage_that_ends_stops_the_robot_and_comes_back(driven: Callable[[str], Driven]) -> None:
    one = driven(chain())
    for name in ("eyes", "middle"):
        one.send(name, signal.SIGKILL)
        one.stop()
        one.drive()
    n_looks = len(one.looks)
    one.show_until(lambda: len(one.looks) > n_looks)
    summary, log = one.run.stop()
    with log:
        for channel in ("see.twist", "relay.twist", "guard.twist"):
            numbers = [int.from_bytes(event.data[16:24], "big") for event in log.events() if event.channel == channel]
            assert numbers == list(range(len(numbers)))
            assert log.utimes(channel) == sorted(set(log.utimes(channel)))
        statuses = statuses_of(log)
    assert {one["name"]: one["restarts"] for one in statuses[-1].stages} == {"see": 1, "relay": 1, "guard": 0}
    assert {name: (told["restarts"], told["ended"]) for name, told in (summary.processes or {}).items()} == {
        name: (1, ["was killed by SIGKILL"]) for name in ("eyes", "middle")
    }
    assert one.run.notices[0] == "process 'eyes' was killed by SIGKILL: it is started again in 0.01 s (1 of 3)"
    assert any(line.endswith(" on see.image: the process of see was started again") for line in one.run.notices)
    assert [line.partition(" after ")[0] for line in one.run.notices if " is back " in line] == [
        "process 'eyes' is back",
        "process 'middle' is back",
    ]


def test_a_guard_that_ends_leaves_the_stop_to_the_motors(driven: Callable[[str], Driven]) -> None:
    one = driven(chain(guard=GUARD))
    one.send("last", signal.SIGKILL)
    one.stop()
    one.drive()
    summary, log = one.run.stop()
    log.close()
    assert (summary.processes or {})["last"]["restarts"] == 1


@pytest.mark.parametrize("name", ["eyes", "last"])
def test_a_stage_that_hangs_stops_the_robot_but_no_other_stage(driven: Callable[[str], Driven], name: str) -> None:
    one = driven(chain(guard=GUARD))
    with suspended(one, name):
        one.stop()
        one.show_until(lambda: any("hangs: " in line for line in one.run.notices))
    one.drive()
    summary, log = one.run.stop()
    with log:
        assert log.count("camera.image") > log.count("see.twist") or name != "eyes"
    (hung,) = {line.partition(" for ")[0] for line in one.run.notices if "hangs: " in line}
    assert hung == f"hangs: {'see' if name == 'eyes' else 'guard'} has been in one step"
    assert all(not told["ended"] for told in (summary.processes or {}).values())


def test_a_run_ends_although_a_process_is_suspended(driven: Callable[[str], Driven]) -> None:
    one = driven(chain(guard=GUARD))
    pids = [one.send(name, signal.SIGSTOP) for name in ("eyes", "middle", "last")]
    one.stop()
    summary, log = one.run.stop()
    log.close()
    assert summary.outcome == "stopped"
    assert one.speeds[-1] == 0.0
    assert not any(map(is_alive, pids))


def test_without_a_policy_the_run_fails_with_a_stop(driven: Callable[[str], Driven]) -> None:
    one = driven(chain("restart: never"))
    one.send("middle", signal.SIGKILL)
    summary, log = one.run.finish()
    log.close()
    assert summary.failure.startswith("stage 'relay' (steps.pass) failed at ")
    assert summary.failure.endswith(
        " s: its process 'middle' was killed by SIGKILL\n"
        "  write deploy: {middle: {stages: [relay], restart: on_failure}} to have it started again"
    )
    wait_until(lambda: one.speeds[-1] == 0.0)


def test_a_failure_is_told_once_while_another_step_goes_on(driven: Callable[[str], Driven]) -> None:
    one = driven(chain("restart: never"))
    one.send("eyes", signal.SIGSTOP)
    one.show_until(lambda: any("hangs: see" in line for line in one.run.notices))
    one.send("middle", signal.SIGKILL)
    summary, log = one.run.finish()
    log.close()
    assert [str(error) for error in one.errors] == [summary.failure]


def test_a_stage_that_ends_at_each_start_is_given_up(
    live: Callable[..., Live], outside: Callable[..., Outside]
) -> None:
    one = Driven(live, outside, chain(relay="{at: 0, what: exit}"))
    summary, log = one.run.finish()
    log.close()
    assert summary.failure == (
        "stage 'relay' (steps.pass) failed at 0.00 s: its process 'middle' ended with exit status 3, "
        "and is given up after 3 restarts in 60 s"
    )
    assert LEVEL not in one.speeds


def test_a_stage_that_ends_too_often_is_given_up_while_the_robot_stands(
    driven: Callable[[str], Driven], tmp_path: Path
) -> None:
    one = driven(chain("restart: on_failure, restart_delay_s: 0.01, max_restarts: 2"))
    for _ in range(2):
        one.send("middle", signal.SIGKILL)
        one.stop()
        one.drive()
    one.send("middle", signal.SIGKILL)
    summary, log = one.run.finish()
    log.close()
    assert summary.outcome == "failed"
    assert "its process 'middle' was killed by SIGKILL, and is given up after 2 restarts in 60 s" in summary.failure
    wait_until(lambda: one.speeds[-1] == 0.0)


def test_changed_stages_are_replayed(driven: Callable[[str], Driven], capsys: pytest.CaptureFixture[str]) -> None:
    """Also one that reads from then on what a stage publishes that makes a step nearly always."""
    one = driven(chain(guard="others: {stages: [slow]}", more=SLOW))
    with ThreadPoolExecutor() as pool:
        for ref in ("slow.twist", "see.twist", "slow.twist"):
            swap = "relay=steps.pass", f"--set relay.in.one={ref}", "guard=probe.pass"
            changed = pool.submit(one.run.changed, *swap)
            one.show_until(changed.done)
            assert changed.result().at_s is not None
            one.drive()
    summary, log = one.run.stop()
    log.close()
    assert [change["stage"] for change in summary.changes] == ["relay", "guard"] * 3
    assert main(["replay", str(one.run.folder), "--plugin", str(STAGES), "--plugin", str(PROBES)]) == 0
    assert "no differences: " in capsys.readouterr().out


def test_a_changed_stage_is_what_a_new_process_has(driven: Callable[[str], Driven], tmp_path: Path) -> None:
    """One that hangs when it is reset leaves the old one driving; if its process ends meanwhile nothing has changed."""
    one = driven(chain())
    assert one.run.changed("relay=steps.pass", "--set relay.what=print", "--set relay.at=1").at_s is not None
    one.drive()
    assert one.run.changed("see.dawdle_s=0.001", "guard=probe.pass").at_s is not None
    one.drive()
    with ThreadPoolExecutor() as pool:
        hanging = pool.submit(one.run.changed, "relay.what=hang", "relay.at=0", f"relay.file={tmp_path / 'hangs'}")
        one.show_until((tmp_path / "hangs").exists)
        one.drive()
        one.send("middle", signal.SIGKILL)
        one.stop()
        one.drive()
        (problem,) = hanging.result().problems
    assert str(problem) == (
        "stage 'relay' (steps.pass) stays as it is: its process 'middle' ended meanwhile\n  ask again"
    )
    summary, log = one.run.stop()
    log.close()
    assert [change["stage"] for change in summary.changes] == ["relay", "see", "guard"]
    assert sum(line.startswith("[middle] step 1") for line in one.run.notices) == 2


def test_a_source_begins_again(live: Callable[..., Live], outside: Callable[..., Outside]) -> None:
    supervisors: list[Supervisor] = []
    program = outside("COUNT")
    run = live(
        """
        run: {until_s: 60, record: all}
        stages:
          clock: {use: steps.count, with: {n: 100000, rate_hz: 50}}
          relay: {use: steps.pass, in: {one: clock}}
        outputs: {relay.twist: {channel: COUNT, motor: false}}
        deploy: {left: {stages: [clock], restart: always, restart_delay_s: 0.01}}
        """,
        supervised=supervisors.append,
    )
    program.wait_for(lambda: len(program.of("COUNT")) > 10)
    pid = supervisors[0].pid_of("left")
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    n_heard = len(program.of("COUNT"))

    def counts() -> list[float]:
        return [v for _, v in program.speeds("COUNT")]

    program.wait_for(lambda: sorted(counts()) != counts() and len(counts()) > n_heard + 10)
    summary, log = run.stop()
    with log:
        stamps = log.utimes("clock.twist")
        assert stamps == sorted(set(stamps))
    assert summary.stages["clock"].steps >= len(counts())


def statuses_of(log: Recording) -> list[Status]:
    """Return the statuses in a log."""
    return [status for _, _, status in log.messages("graphnav.status") if isinstance(status, Status)]


def test_the_status_tells_of_every_process_and_which_way_edges_take(
    driven: Callable[[str], Driven], capsys: pytest.CaptureFixture[str]
) -> None:
    one = driven(chain(guard=GUARD))
    pid = one.send("last", signal.SIGKILL)
    one.show_until(lambda: any("it is started again" in line for line in one.run.notices))
    n_looks = len(one.looks)
    one.show_until(lambda: len(one.looks) > n_looks)
    one.stop()
    one.drive()
    n_looks = len(one.looks)
    one.show_until(lambda: len(one.looks) > n_looks)
    _, log = one.run.stop()
    with log:
        told = [{process["name"]: process for process in status.processes} for status in statuses_of(log)]
    assert [(name, list(process["stages"])) for name, process in told[-1].items()] == [
        ("", []),
        ("eyes", ["see"]),
        ("middle", ["relay"]),
        ("last", ["guard"]),
    ]
    assert [state for state, _ in groupby(processes["last"]["state"] for processes in told)][-2:] == [
        "restarting",
        "ready",
    ]
    assert (told[-1][""]["pid"], told[-1]["last"]["restarts"]) == (os.getpid(), 1)
    assert told[-1]["last"]["pid"] not in {0, pid}
    assert all(process["memory_mb"] > 1.0 for process in told[-1].values())
    ratios = [process["cpu_ratio"] for processes in told for process in processes.values()]
    assert min(ratios) >= 0.0
    assert sum(ratios) > 0.0
    assert main(["top", str(one.run.folder), "--json"]) == 0
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    assert {edge["name"]: (edge["channel"], *edge["processes"]) for edge in run["status"]["edges"]} == {
        "see.image": ("camera.image", "", "eyes"),
        "relay.one": ("see.twist", "eyes", "middle"),
        "guard.command": ("relay.twist", "middle", "last"),
        "guard.image": ("camera.image", "", "last"),
    }


def test_the_last_status_tells_which_process_was_given_up(
    driven: Callable[[str], Driven], capsys: pytest.CaptureFixture[str]
) -> None:
    one = driven(chain("restart: never"))
    one.send("middle", signal.SIGKILL)
    _, log = one.run.finish()
    with log:
        last = {process["name"]: (process["state"], process["pid"] > 0) for process in statuses_of(log)[-1].processes}
    assert last == {"": ("ready", True), "eyes": ("ready", True), "middle": ("given up", False)}
    assert main(["top", str(one.run.folder)]) == 0
    (row,) = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("middle ")]
    assert row[:4] == ["middle", "relay", "given", "up"]
