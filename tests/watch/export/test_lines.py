"""Events of a run are reported once, when they happen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graphnav import GuardState, Message, State, Stop
from graphnav.core.record import LogWriter, Recording
from graphnav.core.run_folder import RunFolder
from graphnav.watch.export.entries.entries import Level
from graphnav.watch.export.entries.event_lines import Lines, outcome_lines


def state(*, contact: bool = False, at_goal: bool = False) -> State:
    return State(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, contact, at_goal, np.empty((0, 3)))


def guard(*causes: tuple[str, str], may_move: bool, overridden: bool = False) -> GuardState:
    names, ports = zip(*causes, strict=True) if causes else ((), ())
    nothing = np.zeros(len(causes))
    return GuardState(may_move, may_move, overridden, False, tuple(names), tuple(ports), nothing, nothing)


def told(*messages: Message) -> list[tuple[int, Level, str]]:
    lines = Lines()
    return [
        (line.utime, line.level, line.text)
        for utime, message in enumerate(messages)
        for line in lines.of("a.b", utime, message)
    ]


def test_contact_and_goal_are_told_when_they_begin() -> None:
    hit = state(contact=True)
    assert told(state(), hit, hit, state(), hit, state(at_goal=True)) == [
        (1, Level.ERROR, "contact"),
        (4, Level.ERROR, "contact"),
        (5, Level.INFO, "goal reached"),
    ]


def test_the_guard_is_told_when_it_changes() -> None:
    late = guard(("stale", "plane"), may_move=False)
    assert told(guard(may_move=True), late, late, guard(may_move=True)) == [
        (1, Level.WARNING, "guard forbids motion: stale plane"),
        (3, Level.INFO, "guard allows all motion"),
    ]
    retry = guard(("frozen", "flow"), may_move=True)
    assert told(retry) == [(0, Level.WARNING, "guard retries slowly: frozen flow")]
    assert told(guard(("stop", ""), may_move=True, overridden=True)) == [(0, Level.INFO, "guard is overridden: stop")]


def test_every_stop_is_told() -> None:
    assert told(Stop(engaged=True, reason="enough"), Stop(engaged=True), Stop(engaged=False)) == [
        (0, Level.WARNING, "stop requested: enough"),
        (1, Level.WARNING, "stop requested"),
        (2, Level.INFO, "armed again"),
    ]


@pytest.mark.parametrize(
    ("summary", "texts"),
    [
        ('{"outcome": "contact", "notices": ["plane: pruned"], "failure": ""}', ["plane: pruned", "outcome: contact"]),
        ('{"outcome": "failed", "failure": "stage fell"}', ["stage fell", "outcome: failed"]),
        ('{"outcome": null, "notices": 5}', []),
        ("[]", []),
        ("[" * 100_000, []),
        ("not JSON", []),
        (None, []),
    ],
)
def test_the_outcome_is_that_of_the_run_folder(tmp_path: Path, summary: str | None, texts: list[str]) -> None:
    LogWriter(tmp_path / "run.lcmlog").close()
    if summary is not None:
        (tmp_path / RunFolder.SUMMARY).write_text(summary)
    with Recording(tmp_path / "run.lcmlog") as recording:
        assert [line.text for line in outcome_lines(recording, 0, 1)] == texts
