"""``graphnav top``: what runs say of their health, live and in logs; silence is never shown as health."""

from __future__ import annotations

import json
import os
import pty
import re
import shutil
import signal
import subprocess
import sysconfig
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testbed.terminal import Terminal

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.machine.console import Console
from graphnav.core.messages import About, GuardState, Message, Status
from graphnav.core.record import LogWriter
from graphnav.core.runner import ProcessState
from graphnav.watch.feed import MAX_RUNS, Health, Received
from graphnav.watch.spy import health_as_json, health_as_text

GRAPHNAV = str(Path(sysconfig.get_path("scripts")) / "graphnav")
STAGE = {
    "name": "flow",
    "use": "flow.dis",
    "steps": 120,
    "rate_hz": 9.97,
    "p50_ms": 12.25,
    "p99_ms": 31.5,
    "deadline_ms": 80.0,
    "missed": 3,
    "overtaken": 7,
    "restarts": 0,
}
INPUT: dict[str, Any] = {
    "name": "camera.image",
    "channel": "CAMERA",
    "accepted": 121,
    "lost": 4,
    "rate_hz": 10.02,
    "age_s": 0.04,
    "max_age_s": 0.5,
    "offset_s": -0.0123,
    "fault": "",
    "clock": "",
    "reasons": ("undecodable", "repeated"),
    "rejected": np.array([2, 5]),
    "details": ("image_t: rows is 0, expected 1 or more", ""),
}
OUTPUT = {
    "name": "guard.twist",
    "channel": "BASE_CMD",
    "motor": True,
    "sent": 240,
    "refused": 3,
    "fault": "",
    "latency_p50_ms": 22.0,
    "latency_p99_ms": 41.5,
    "latency_max_ms": 60.25,
}
STATUS = Status(
    run_id="run-a",
    graph="robot",
    live=True,
    wall_s=12.34,
    run_s=12.3,
    behind_s=0.04,
    memory_mb=151.6,
    tap_dropped=1,
    log_dropped=2,
    log_fault="",
    stages=(STAGE,),
    inputs=(INPUT,),
    outputs=(OUTPUT,),
    edges=({"name": "plane.flow", "channel": "flow.flow", "overtaken": 4},),
)
STOPPED = GuardState(
    may_move=False,
    may_advance=False,
    overridden=False,
    stopped=True,
    causes=("stale", "stop"),
    ports=("image", "stop"),
    values=np.array([1.25, 0.0]),
    limits=np.array([0.5, 0.0]),
)
ABOUT_B = About("stages: {}\n", "", "run-b", 7, (), ())


def text_of(health: Health, width: int = 140) -> str:
    """Return what a person reads, in a terminal of some width."""
    console = Console(width=width, color_system=None)
    with console.capture() as said:
        console.print(health_as_text(health, width))
    return said.get()


def test_an_output_that_sent_only_stops_has_no_latency() -> None:
    health = Health(lambda: 10.5)
    output = OUTPUT | {f"latency_{name}_ms": 0.0 for name in ("p50", "p99", "max")}
    health.receive(Received("graphnav.status", encode(replace(STATUS, outputs=(output,)), 12_300_000, 12), 10.4))
    (row,) = [line for line in text_of(health).splitlines() if line.startswith("guard.twist")]
    assert row.split() == ["guard.twist", "BASE_CMD", "motor", "240", "3"]


def process(name: str, *stages: str, pid: int = 4242, state: str = "ready", restarts: int = 0) -> dict[str, Any]:
    """Return the status of a process."""
    load = {"cpu_ratio": 0.254, "memory_mb": 61.7}
    return ProcessState(name, stages, pid, state, restarts)._asdict() | load  # type: ignore[arg-type]


OVER_PROCESSES = replace(
    STATUS,
    stages=(STAGE, STAGE | {"name": "plane", "use": "plane.affine"}, STAGE | {"name": "guard", "use": "control.guard"}),
    edges=(
        {"name": "flow.image", "channel": "camera.image", "overtaken": 0},
        {"name": "guard.plane", "channel": "plane.plane", "overtaken": 0},
        {"name": "plane.flow", "channel": "flow.flow", "overtaken": 4},
    ),
    processes=(
        process("", "guard", pid=4000),
        process("eyes", "flow", "plane", restarts=2),
        process("late", "other", pid=0, state="restarting", restarts=1),
    ),
)


def rows_of(text: str, heading: str) -> list[list[str]]:
    """Return the rows of a table without its heading and the line below it, split at two spaces."""
    lines = text.splitlines()
    begin = lines.index(next(line for line in lines if line.startswith(heading))) + 2
    rules = [number - 1 for number, line in enumerate(lines) if line.startswith("─") and number > begin]
    return [re.split(r" {2,}", line.strip()) for line in lines[begin : min(rules, default=len(lines))]]


def test_the_processes_of_a_run_and_the_ways_of_its_edges_are_told() -> None:
    health = Health(lambda: 10.5)
    health.receive(Received("graphnav.status", encode(OVER_PROCESSES, 12_300_000, 12), 10.4))
    text = text_of(health)
    assert rows_of(text, "process") == [
        ["(run)", "guard", "4000", "ready", "0", "25 %", "62 MB"],
        ["eyes", "flow, plane", "4242", "ready", "2", "25 %", "62 MB"],
        ["late", "other", "restarting", "1", "25 %", "62 MB"],
    ]
    assert [row[:3] for row in rows_of(text, "stage")] == [
        ["flow", "flow.dis", "eyes"],
        ["plane", "plane.affine", "eyes"],
        ["guard", "control.guard", "(run)"],
    ]
    assert rows_of(text, "edge") == [
        ["flow.image", "camera.image", "(run) → eyes", "0"],
        ["guard.plane", "plane.plane", "eyes → (run)", "0"],
        ["plane.flow", "flow.flow", "within eyes", "4"],
    ]
    assert "overtaken on edges" not in text
    ways = [edge["processes"] for edge in health_as_json(health, "")["runs"][0]["status"]["edges"]]
    assert ways == [("", "eyes"), ("eyes", ""), ("eyes", "eyes")]


@pytest.mark.parametrize(
    ("clock", "told"),
    [
        ({}, "jetson: not measured"),
        (
            {"round_trip_ms": 0.41, "clock_offset_s": 0.0123, "clock_error_s": 0.0002},
            "jetson: 0.4 ms away, clock 12.3 ms ahead ± 0.2 ms",
        ),
        (
            {"round_trip_ms": 8.0, "clock_offset_s": -0.003, "clock_error_s": 0.004, "clock_drift_ppm": -0.2},
            "jetson: 8.0 ms away, clock alike within 4.0 ms, 0 ppm",
        ),
        (
            {
                "round_trip_ms": 0.4,
                "clock_offset_s": -3600.0,
                "clock_error_s": 2e-4,
                "clock_drift_ppm": 3.0,
                "clock_steps": 2,
            },
            "jetson: 0.4 ms away, clock 3600 s behind ± 0.2 ms, 3 ppm, set 2 times",
        ),
    ],
)
def test_the_clock_of_a_host_is_told(clock: dict[str, float], told: str) -> None:
    health = Health(lambda: 10.5)
    processes = (OVER_PROCESSES.processes[0], process("eyes", "flow", "plane") | {"host": "jetson"} | clock)
    status = replace(OVER_PROCESSES, processes=processes)
    health.receive(Received("graphnav.status", encode(status, 12_300_000, 12), 10.4))
    assert rows_of(text_of(health), "process")[1][-1] == told
    assert told.rsplit(maxsplit=1)[-1] in text_of(health, 80), "it is wrapped, and never cut"
    own, eyes = health_as_json(health, "")["runs"][0]["status"]["processes"]
    assert (own["host"], own["host_shown"], own["clock_offset_s"]) == ("", "", None)
    assert (eyes["host"], eyes["host_shown"]) == ("jetson", told)
    assert eyes["clock_offset_s"] == clock.get("clock_offset_s")


def test_in_lockstep_no_edge_drops_anything() -> None:
    health = Health(lambda: 10.5)
    health.receive(Received("graphnav.status", encode(replace(OVER_PROCESSES, live=False), 12_300_000, 12), 10.4))
    assert rows_of(text_of(health), "edge")[-1] == ["plane.flow", "flow.flow", "within eyes"]


def test_a_run_in_one_process_shows_none() -> None:
    health = Health(lambda: 10.5)
    health.receive(Received("graphnav.status", encode(STATUS, 12_300_000, 12), 10.4))
    assert not {"process", "edge", "way", "restarts"} & set(text_of(health).split())


def test_processes_of_a_hostile_status_are_text_of_bounded_length() -> None:
    health = Health(lambda: 10.5)
    many = tuple(process(f"\x1b[2J{k}", f"\x1b]0;{k}", pid=-(2**63), state="\x07", restarts=-1) for k in range(3000))
    load = {"cpu_ratio": float("nan"), "memory_mb": float("-inf"), "host": "\x1b]0;h"}
    load |= {"round_trip_ms": 1e300, "clock_offset_s": -1e300, "clock_error_s": 0.0, "clock_drift_ppm": 1e300}
    edges = tuple({"name": f"\x1b{k}", "channel": "\u202e", "overtaken": 2**63 - 1} for k in range(3000))
    hostile = replace(OVER_PROCESSES, processes=(many[0] | load, *many), edges=edges)
    health.receive(Received("graphnav.status", encode(hostile, 12_300_000, 12), 10.4))
    text = text_of(health)
    assert not {"\x1b", "\x07", "\u202e"} & set(text)
    assert text.splitlines().count("and 2000 more") == 1
    assert text.splitlines().count("and 2001 more") == 1
    assert "nan %" in text
    assert json.loads(json.dumps(health_as_json(health, ""), allow_nan=False))


def test_a_robot_that_the_guard_holds_tells_what_to_do() -> None:
    health = Health(lambda: 10.5)
    held = replace(STOPPED, causes=("frozen",), ports=("flow",), values=np.array([0.01]), limits=np.array([0.1]))
    health.receive(Received("guard.state", encode(held, 12_300_000, 12), 10.4))
    assert [line.strip() for line in text_of(health).splitlines()] == [
        "guard guard.state  may not move, stopped until it is armed again",
        "frozen: flow, 0.01 px (limit 0.1 px)",
        "look, then press r in graphnav teleop to let it retry, or drive it by hand",
    ]


def test_a_robot_that_retries_does_not_look_as_if_nothing_were_wrong() -> None:
    health = Health(lambda: 10.5)
    retrying = replace(
        STOPPED,
        may_move=True,
        may_advance=True,
        stopped=False,
        causes=("reversed",),
        ports=("odometry",),
        values=np.array([-1.0]),
        limits=np.array([0.0]),
    )
    health.receive(Received("guard.state", encode(retrying, 12_300_000, 12), 10.4))
    assert [line.strip() for line in text_of(health).splitlines()] == [
        "guard guard.state  may move, retries slowly",
        "reversed: odometry, -1 (limit 0)",
    ]
    (guard,) = health_as_json(health, "")["guards"]
    assert guard["retrying"]
    health.receive(Received("guard.state", encode(replace(retrying, overridden=True), 12_400_000, 13), 10.4))
    assert "retries" not in text_of(health)


def test_a_person_reads_all_of_a_status() -> None:
    health = Health(lambda: 10.5)
    assert health.receive(Received("graphnav.status", encode(STATUS, 12_300_000, 12), 10.0))
    health.receive(Received("guard.state", encode(STOPPED, 12_300_000, 12), 10.4))
    lines = [re.sub(r"\s+", " ", line).strip() for line in text_of(health).splitlines()]
    assert [line for line in lines if line and not line.startswith("─")] == [
        "guard guard.state may not move, stopped until it is armed again",
        "stale: image, 1.25 s (limit 0.5 s)",
        "stop: stop",
        "run run-a robot live, 12.3 s of wall time, 0.04 s behind, 152 MB, dropped: tap 1, log 2",
        "input channel accepted lost rate age / max offset fault rejected",
        "camera.image CAMERA 121 4 10.0 Hz 0.04 / 0.50 s -0.012 s undecodable 2, repeated 5",
        "camera.image, undecodable: image_t: rows is 0, expected 1 or more",
        "output channel sent refused latency p50 p99 max fault",
        "guard.twist BASE_CMD motor 240 3 22.0 ms 41.5 ms 60.2 ms",
        "stage uses rate p50 p99 deadline missed overtaken",
        "flow flow.dis 10.0 Hz 12.2 ms 31.5 ms 80 ms 3 7",
        "overtaken on edges: plane.flow 4",
    ]


def test_a_log_that_takes_nothing_is_told() -> None:
    health = Health(lambda: 10.5)
    health.receive(Received("graphnav.status", encode(replace(STATUS, log_fault="No space\x1b left"), 0, 0), 10.0))
    lines = text_of(health).splitlines()
    assert lines[0].startswith("run run-a  robot  live, ")
    assert lines[1] == "not recording: No space\\x1b left"


def test_80_columns_and_24_lines_show_what_matters_most() -> None:
    stages = tuple({**STAGE, "name": f"a_stage_of_a_long_name_{k}"} for k in range(9))
    inputs = tuple(
        {**INPUT, "name": name, "reasons": (), "rejected": np.zeros(0, int), "details": ()}
        for name in ("image", "stop")
    )
    health = Health()
    health.receive(Received("graphnav.status", encode(replace(STATUS, stages=stages, inputs=inputs), 0, 0), 0.0))
    health.receive(Received("guard.state", encode(STOPPED, 0, 0), 0.0))
    lines = [line.rstrip() for line in text_of(health, 80).splitlines()]
    assert lines[:16] == [
        "guard guard.state  may not move, stopped until it is armed again",
        "    stale: image, 1.25 s (limit 0.5 s)",
        "    stop: stop",
        "run run-a  robot  live, 12.3 s of wall time, 0.04 s behind, 152 MB, dropped: tap",
        "1, log 2",
        "input  accepted  lost  rate     age / max      fault  rejected",
        "─" * 62,
        "image  121       4     10.0 Hz  0.04 / 0.50 s",
        "stop   121       4     10.0 Hz  0.04 / 0.50 s",
        "output              sent  refused  latency p50  p99      fault",
        "─" * 62,
        "guard.twist  motor  240   3        22.0 ms      41.5 ms",
        "stage                     rate     p50      p99      missed  overtaken",
        "─" * 70,
        "a_stage_of_a_long_name_0  10.0 Hz  12.2 ms  31.5 ms  3       7",
        "a_stage_of_a_long_name_1  10.0 Hz  12.2 ms  31.5 ms  3       7",
    ]


def test_long_names_are_cut_and_numbers_are_not() -> None:
    stage = {**STAGE, "name": "n" * 60}
    health = Health()
    health.receive(Received("graphnav.status", encode(replace(STATUS, stages=(stage,)), 0, 0), 0.0))
    (line,) = (line for line in text_of(health, 80).splitlines() if "nnn" in line)
    assert re.fullmatch(r"n+…  10\.0 Hz  12\.2 ms  31\.5 ms  3       7 *", line)


def test_runs_that_drive_a_motor_come_first() -> None:
    health = Health()
    for run_id, outputs in (("a", ()), ("b", (OUTPUT,)), ("c", ())):
        health.receive(Received("graphnav.status", encode(replace(STATUS, run_id=run_id, outputs=outputs), 0, 0), 0.0))
    assert re.findall(r"^run (\w)", text_of(health), re.MULTILINE) == ["b", "a", "c"]


def test_silence_is_shown_as_silence() -> None:
    now_s = 10.0
    health = Health(lambda: now_s)
    health.receive(Received("graphnav.status", encode(STATUS, 0, 0), 10.0))
    health.receive(Received("guard.state", encode(replace(STOPPED, may_move=True, may_advance=True), 0, 0), 10.0))
    assert "no st" not in text_of(health)
    assert "guard guard.state  may move" in text_of(health)
    now_s = 13.2
    assert "run run-a  robot  no status for 3.2 s  live, " in text_of(health)
    assert "guard guard.state  no state for 3.2 s\n" in text_of(health)
    assert "may move" not in text_of(health)
    now_s = 90.0
    assert "flow.dis" not in text_of(health), "what was long ago is told in one line"
    health.receive(Received("graphnav.status", encode(STATUS, 0, 1), 90.0))
    assert "no status" not in text_of(health)


def test_a_guard_whose_commands_are_not_sent_does_not_look_as_if_the_robot_may_move() -> None:
    health = Health()
    output = {**OUTPUT, "fault": "not taken for 0.1 s: nothing is sent"}
    health.receive(Received("graphnav.status", encode(replace(STATUS, outputs=(output,)), 0, 0), 0.0))
    for name in ("guard", "other"):
        health.receive(Received(f"{name}.state", encode(replace(STOPPED, may_move=True, may_advance=True), 0, 0), 0.0))
    lines = text_of(health).splitlines()
    assert (
        "guard guard.state  may move, but not taken for 0.1 s: nothing is sent, stopped until it is armed again"
        in lines
    )
    assert "guard other.state  may move, stopped until it is armed again" in lines


def test_a_run_that_was_only_announced_has_no_status() -> None:
    health = Health(lambda: 4.0)
    health.receive(Received(About.CHANNEL, encode(ABOUT_B, 0, 0), 1.0))
    assert not health.is_complete
    assert text_of(health) == "run run-b  no status for 3.0 s\n"


def test_what_no_terminal_should_obey_is_not_printed() -> None:
    health = Health()
    health.receive(Received("x", encode(replace(STATUS, run_id="\x1b[2J\x1b]0;x\x07"), 0, 0), 0.0))
    assert "\x1b" not in text_of(health)


def test_damaged_messages_are_left_aside() -> None:
    health = Health()
    for message in (STATUS, STOPPED, ABOUT_B):
        health.receive(Received(About.CHANNEL, encode(message, 0, 0)[:-3], 0.0))
    assert (health.runs, health.guards) == ({}, {})


def test_invented_runs_and_guards_do_not_fill_the_memory() -> None:
    health = Health()
    for k in range(3 * MAX_RUNS):
        health.receive(Received(About.CHANNEL, encode(replace(ABOUT_B, run_id=f"run-{k}"), 0, 0), k))
        health.receive(Received("graphnav.status", encode(replace(STATUS, run_id="real"), 0, k), k))
        health.receive(Received(f"guard-{k}", encode(STOPPED, 0, 0), k))
    assert len(health.runs) == MAX_RUNS
    assert health.runs["real"].seq == 3 * MAX_RUNS - 1, "who is received again and again is not forgotten"
    assert f"run-{3 * MAX_RUNS - 1}" in health.runs
    assert list(health.guards) == [f"guard-{k}" for k in range(2 * MAX_RUNS, 3 * MAX_RUNS)]


def test_types_that_are_not_there_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "run.lcmlog") as log:
        log.write("graphnav.status", 0, encode(STATUS, 0, 0))
    assert main(["top", str(tmp_path), "--types", "no_such_package"]) == 2
    assert "no_such_package" in capsys.readouterr().err
    assert main(["top", str(tmp_path), "--types", "graphnav_lcm"]) == 0


def test_the_last_status_of_a_log_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "run.lcmlog") as log:
        for k in range(5):
            log.write("graphnav.status", k, encode(replace(STATUS, wall_s=float(k)), 1_000_000 * k, k))
    assert main(["top", str(tmp_path), "--json"]) == 0
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    assert (run["status"]["seq"], run["status"]["wall_s"], run["silent_s"], run["silent"]) == (4, 4.0, None, False)
    assert main(["top", str(tmp_path / "run.lcmlog")]) == 0
    assert "run run-a  robot  live, 4.0 s of wall time" in capsys.readouterr().out


def test_a_log_without_status_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("guard.state", 0, encode(STOPPED, 0, 0))
    assert main(["top", str(tmp_path / "log")]) == 1
    assert (
        capsys.readouterr().err == f"{tmp_path / 'log'} does not contain a status of a run: only live runs record it\n"
    )


@pytest.mark.parametrize("option", ["--once", "--json"])
def test_no_run_is_said_in_a_line(group: str, capsys: pytest.CaptureFixture[str], option: str) -> None:
    assert main(["top", group, "--for", "0.05", option]) == 1
    said = f"no run on {group} within 0.05 s: start one with 'graphnav run GRAPH --live'\n"
    assert capsys.readouterr().err == said


Publish = Callable[..., AbstractContextManager[None]]


@pytest.fixture
def publishing(group: str) -> Publish:
    """Return a context manager that publishes messages again and again until the block ends."""

    @contextmanager
    def published(*messages: tuple[str, Message]) -> Iterator[None]:
        over = threading.Event()

        def run() -> None:
            bus, k = Bus(group), 0
            while not over.wait(0.02):
                for channel, message in messages:
                    bus.publish(channel, encode(message, 1_000_000 * k, k))
                k += 1
            bus.close()

        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    return published


def test_two_runs_at_once_are_both_told(group: str, publishing: Publish, capsys: pytest.CaptureFixture[str]) -> None:
    other = replace(STATUS, run_id="run-b", live=False, stages=(), inputs=(), outputs=(), edges=())
    said = (("graphnav.status", STATUS), ("graphnav.status", other), ("guard.state", STOPPED), (About.CHANNEL, ABOUT_B))
    with publishing(*said):
        assert main(["top", "--json", "--for", "60", group]) == 0
        told = json.loads(capsys.readouterr().out)
        assert main(["top", "--once", "--for", "60", group]) == 0
    text = capsys.readouterr().out
    a, b = told["runs"]
    assert (a["run_id"], b["run_id"], b["status"]["live"], b["silent"]) == ("run-a", "run-b", False, False)
    assert a["status"]["stages"] == [STAGE]
    given = {name: value for name, value in INPUT.items() if name != "reasons"}
    assert a["status"]["inputs"] == [given | {"rejected": REJECTED, "details": {"undecodable": INPUT["details"][0]}}]
    assert a["status"]["outputs"] == [OUTPUT]
    assert a["status"]["edges"] == [{"name": "plane.flow", "channel": "flow.flow", "overtaken": 4}]
    assert a["status"]["processes"] == []
    scalars = {"graph": "robot", "behind_s": 0.04, "memory_mb": 151.6, "tap_dropped": 1, "log_dropped": 2}
    assert scalars.items() <= a["status"].items()
    (guard,) = told["guards"]
    assert guard["causes"][0] == {"cause": "stale", "port": "image", "value": 1.25, "limit": 0.5}
    assert (guard["channel"], guard["may_move"], guard["stopped"]) == ("guard.state", False, True)
    assert re.search(r"^run run-a  robot  live, ", text, re.MULTILINE)
    assert re.search(r"^run run-b  robot  lockstep, 12.3 s simulated", text, re.MULTILINE)


def test_an_announced_run_without_status_is_waited_for_and_named(
    group: str, publishing: Publish, capsys: pytest.CaptureFixture[str]
) -> None:
    with publishing((About.CHANNEL, ABOUT_B)):
        assert main(["top", "--once", "--for", "1", group]) == 1
    assert capsys.readouterr().err == f"no status within 1 s of run run-b, which is received on {group}\n"


def test_it_is_shown_live_until_ctrl_c(group: str, publishing: Publish) -> None:
    terminal, screen = pty.openpty()
    command = [GRAPHNAV, "top", group, "--for", "60"]
    with subprocess.Popen(command, stdin=screen, stdout=screen, stderr=screen, env=WIDE) as process:
        os.close(screen)
        shown = b""
        with publishing(("graphnav.status", STATUS)):
            while b"overtaken on edges" not in shown:
                shown += os.read(terminal, 65536)
        while not re.search(rb"no status for \d", shown):
            shown += os.read(terminal, 65536)
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130
    os.close(terminal)
    assert b"run-a" in shown


def test_a_run_that_has_not_begun_is_waited_for(group: str, publishing: Publish) -> None:
    terminal, screen = pty.openpty()
    command = [GRAPHNAV, "top", group, "--for", "0.2"]
    with subprocess.Popen(command, stdin=screen, stdout=screen, stderr=screen, env=WIDE) as process:
        os.close(screen)
        shown = b""
        while b"waiting for it; Ctrl-C exits" not in shown:
            shown += os.read(terminal, 65536)
        assert f"no run on {group} within 0.2 s".encode() in shown
        with publishing(("graphnav.status", STATUS)):
            while b"overtaken on edges" not in shown:
                shown += os.read(terminal, 65536)
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130
    os.close(terminal)


REJECTED = {"undecodable": 2, "repeated": 5}
WIDE = {**os.environ, "COLUMNS": "160", "LINES": "50", "TERM": "xterm"}


@pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed")
def test_keys_of_the_screen(group: str, tmp_path: Path) -> None:
    over, one = threading.Event(), Terminal(tmp_path / "tmux")

    def publish() -> None:
        bus, k = Bus(group), 0
        while not over.wait(0.1):
            status = replace(STATUS, wall_s=0.1 * k)
            bus.publish("graphnav.status", encode(status, 100_000 * k, k))
            k += 1
        bus.close()

    def clock(shown: str) -> str:
        return "".join(re.findall(r"live, (\S+) s of wall time", shown))

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        one.start(f"{GRAPHNAV} top '{group}'; echo left $?; sleep 60", (120, 40))
        one.wait_for(lambda shown: "? keys" in shown and clock(shown) != "")
        one.press("?")
        first = one.wait_for(lambda shown: "freeze the view, or go on" in shown and "quit" in shown)
        one.wait_for(lambda shown: clock(shown) not in {"", clock(first)})
        one.press("?")
        one.wait_for(lambda shown: "freeze the view" not in shown)
        one.press("Space")
        frozen = one.wait_for(lambda shown: "FROZEN" in shown)
        one.press("?")
        assert clock(one.wait_for(lambda shown: "freeze the view" in shown)) == clock(frozen)
        one.press("q")
        one.wait_for(lambda shown: "left 0" in shown)
    finally:
        over.set()
        thread.join()
        one.close()
