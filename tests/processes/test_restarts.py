"""A process that ends before its run does is started again and fed what it was given, as the graph says, or not."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Graph, graph_of, load_graph
from graphnav.core.runner import Encoded
from graphnav.processes.frames import Kind
from graphnav.processes.journal import Journal
from graphnav.processes.supervisor import Supervisor
from tests.processes.conftest import STAGES, STEPS, Ran, Runs, restarted, steps_graph

PARTS = "deploy: {left: {stages: [clock, second, open]}, right: {stages: [fast, third]}}"
RIGHT = "deploy: {{right: {{stages: [third], {policy}}}}}"
FAST = "restart_delay_s: 0.01"
STOP_BYTES = 28 + len("second.sum") + 40
"""The last event of a log, which takes the last command to a source back."""


def right(tmp_path: Path, policy: str, third: str) -> Graph:
    """Return the graph with one process, in which something happens."""
    return steps_graph(tmp_path, RIGHT.format(policy=policy), third=third)


def test_processes_that_are_killed_leave_the_same_log(runs: Runs, tmp_path: Path) -> None:
    graph = restarted(steps_graph(tmp_path, PARTS))
    ran = runs(graph, {0.0: "left", 0.4: "right", 0.5: "left", 1.6: "left", 1.601: "right"})
    assert ran.agrees_with(runs(replace(graph, deploy={})))
    ended = {name: told["ended"] for name, told in (ran.summary.processes or {}).items()}
    assert ended["right"] == ["was killed by SIGKILL"] * 2
    assert len(ended["left"]) >= 2
    assert ran.notices[0] == "process 'left' was killed by SIGKILL: it is started again in 0 s (1 of 100)"


@pytest.mark.long
def test_stages_of_a_drive_that_are_killed_leave_the_same_log(runs: Runs) -> None:
    graph = load_graph("corridor_ccw", Catalog())
    parts: Mapping[str, Any] = graph.with_processes().deploy
    graph = replace(
        graph, run=replace(graph.run, until_s=1.5), deploy={n: parts[n] for n in ("robot", "flow", "plane")}
    )
    ran = runs(restarted(graph), {0.3: "robot", 0.7: "flow", 1.1: "plane"})
    assert ran.agrees_with(runs(replace(graph, deploy={})))


def test_without_a_policy_the_run_fails_and_says_what_would_help(runs: Runs, tmp_path: Path) -> None:
    in_one, ran = runs(steps_graph(tmp_path)), runs(right(tmp_path, "restart: never", "{}"), {1.0: "right"})
    assert ran.summary.failure == (
        "stage 'third' (steps.pass) failed at 1.00 s: its process 'right' was killed by SIGKILL\n"
        "  write deploy: {right: {stages: [third], restart: on_failure}} to have it started again and fed what it was "
        "given"
    )
    assert in_one.log.startswith(ran.log[:-STOP_BYTES])
    assert ran.summary.frames > 10
    assert "third" not in ran.summary.scores
    assert ran.summary.scores["second"]["steps"] == 11


@pytest.mark.parametrize("third", ["{at: 0, what: exit}", "{at: 4, what: exit}"], ids=["at-each-start", "at-a-step"])
def test_what_ends_each_time_is_given_up(runs: Runs, tmp_path: Path, third: str) -> None:
    ran = runs(right(tmp_path, f"restart: on_failure, max_restarts: 2, {FAST}", third))
    at = "0.00" if "at: 0" in third else "0.30"
    assert ran.summary.failure == (
        f"stage 'third' (steps.pass) failed at {at} s: its process 'right' ended with exit status 3, "
        "and is given up after 2 restarts in 60 s"
    )
    assert [notice.partition(" in ")[2] for notice in ran.notices] == ["0.01 s (1 of 2)", "0.02 s (2 of 2)"]


@pytest.mark.parametrize("policy", ["on_failure", "always"])
def test_an_end_with_status_0_is_a_failure_unless_it_is_always_started_again(
    runs: Runs, tmp_path: Path, policy: str
) -> None:
    third = f"{{at: 3, what: once, file: {tmp_path / 'ended'}}}"
    ran = runs(right(tmp_path, f"restart: {policy}, {FAST}", third))
    if policy == "always":
        assert ran.agrees_with(runs(steps_graph(tmp_path, third=third)))
    else:
        assert (
            "its process 'right' ended with exit status 0\n  write deploy: {right: {stages: [third], restart: always}}"
            in (ran.summary.failure)
        )


def test_a_stage_that_is_not_a_function_of_its_inputs_is_told(runs: Runs, tmp_path: Path) -> None:
    ran = runs(restarted(right(tmp_path, "restart: always", "{what: random}")), {1.0: "right"})
    assert ran.summary.failure == (
        "stage 'third' (steps.pass) failed at 1.00 s: its process 'right' cannot go on: stage 'third' did not publish "
        "the same when it was given the same again: what it does depends on more than its parameters, seed and inputs"
    )


def test_code_that_has_changed_since_the_run_began_is_refused(runs: Runs, tmp_path: Path) -> None:
    plugin = Path(shutil.copy(STAGES, tmp_path / "steps_copy.py"))
    plugin.write_text(plugin.read_text().replace('"steps"\n', '"copied_steps"\n'))
    text = STEPS.format(deploy=RIGHT.format(policy="restart: always"), first="{}", third="{}", more="")
    catalog = Catalog().add_files([plugin])
    graph = graph_of(text.replace("steps.", "copied_steps.").encode(), tmp_path / "steps.yaml", catalog)

    def change(_: Supervisor) -> None:
        plugin.write_text(plugin.read_text() + "\n# changed\n")

    ran: Ran = runs(restarted(replace(graph, plugins=(plugin,))), {1.0: "right"}, killed=change)
    assert f"its process 'right' cannot go on: it does not have what the run began with, but another {plugin}: " in (
        ran.summary.failure
    )


def test_nothing_is_started_again_once_the_user_asked_for_the_end(runs: Runs, tmp_path: Path) -> None:
    def ask(supervisor: Supervisor) -> None:
        supervisor.is_asked_to_stop = lambda: True

    ran: Ran = runs(right(tmp_path, "restart: always, restart_delay_s: 0.2", "{}"), {1.0: "right"}, killed=ask)
    assert (ran.summary.outcome, ran.summary.failure) == ("stopped", "")
    assert (ran.summary.processes or {})["right"]["ended"] == ["was killed by SIGKILL"]


def test_a_journal_without_a_disk_says_why_nothing_can_be_given_again(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "missing")
    journal.keep("right", Kind.FIRE, [0, 1, []], [Encoded(b"a")], 0)
    assert journal.fault == "what it was given cannot be kept: No such file or directory"
    with pytest.raises(GraphnavError, match="cannot be kept"):
        next(journal.steps("right"))


def test_a_journal_leaves_the_last_of_a_disk_to_the_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = Journal(tmp_path)
    journal.keep("right", Kind.FIRE, [0, 1, []], [Encoded(bytes(16 << 20))], 0)
    assert journal.fault == ""
    monkeypatch.setattr("graphnav.core.runner.recording.full_log._MIN_FREE_BYTES", 1 << 60)
    journal.keep("right", Kind.FIRE, [0, 2, []], [Encoded(bytes(16 << 20))], 0)
    assert journal.fault == "what it was given cannot be kept: the disk is nearly full"


def test_a_journal_holds_a_message_once_and_gives_all_again(tmp_path: Path) -> None:
    journal, shared, own = Journal(tmp_path), Encoded(b"shared"), Encoded(b"own")
    journal.keep("left", Kind.FIRE, [0, 1, []], [shared], 5)
    journal.keep("right", Kind.FIRE, [0, 1, []], [shared, own], 6)
    journal.keep("left", Kind.CHANGE, {"place": 0}, (), 0)
    journal.keep("left", Kind.FIRE, [1, 2, [[0.5, True]]], [own], 7)
    assert list(journal.steps("left")) == [
        (Kind.FIRE, [0, 1, []], (b"shared",), 5),
        (Kind.CHANGE, {"place": 0}, (), 0),
        (Kind.FIRE, [1, 2, [[0.5, True]]], (b"own",), 7),
    ]
    assert [given.messages for given in journal.steps("right")] == [(b"shared", b"own")]
    assert list(tmp_path.iterdir()) == []
    journal.close()
