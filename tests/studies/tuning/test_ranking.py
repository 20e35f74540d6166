"""Ranks of rivals, and whether a tuning has failed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from graphnav.studies.tuning import Rival, Trial, TuningRun, conclusion

WORLDS = [("g", seed) for seed in range(4)]
RIVALS = tuple(Rival(label, (), (), {}, ()) for label in "ABC")


def a_run(rivals: Sequence[Rival], *trials: Trial) -> TuningRun:
    tuning: Any = SimpleNamespace(rivals=rivals, metrics={"drive.success": "higher"}, runs_per_trial=len(WORLDS))
    return TuningRun(tuning, list(trials))


def a_trial(rival: str, number: int, values: Mapping[int, float], failed: Sequence[int] = ()) -> Trial:
    """Return a trial with values and failures by world."""
    found = {"drive.success": {WORLDS[world]: value for world, value in values.items()}}
    return Trial(rival, number, {"x": number} if number else {}, found, "", {WORLDS[world]: "boom" for world in failed})


def test_rivals_that_are_equal_change_no_rank() -> None:
    half, less, full = (dict(enumerate(values)) for values in ((0, 0, 1, 1), (0, 0, 0, 1), (1, 1, 1, 1)))
    found = [a_trial(rival, 0, half) for rival in "AB"]
    found += [a_trial("A", 1, less), a_trial("A", 2, full), a_trial("B", 1, full)]
    run = a_run(RIVALS[:2], *found)
    assert [rival.label for rival in run.ranking(tuned=True)] == ["A", "B"]
    assert conclusion(run) == "Tuning moves no rank: A and B (equal)."


def test_what_becomes_equal_is_said_so() -> None:
    half, full = (dict(enumerate(values)) for values in ((0, 0, 1, 1), (1, 1, 1, 1)))
    run = a_run(RIVALS, a_trial("A", 0, half), a_trial("B", 0, half), a_trial("C", 0, full), a_trial("A", 1, full))
    assert conclusion(run) == (
        "Tuning moves the ranking: as they are C, then A and B (equal); tuned A and C (equal), then B."
    )


@pytest.mark.parametrize(
    ("values", "failed", "tells_nothing"),
    [
        ({3: 1.0}, [0, 1, 2], False),
        ({2: 1.0, 3: 0.5}, [0, 1], False),
        ({0: 0.0, 1: 0.0}, [0, 1], True),
        ({}, [], True),
        ({}, [0, 1, 2, 3], True),
    ],
)
def test_a_tuning_has_failed_where_no_run_that_ended_has_the_metric(
    values: Mapping[int, float], failed: Sequence[int], tells_nothing: bool
) -> None:
    assert a_run(RIVALS, *(a_trial(rival, 0, values, failed) for rival in "ABC")).has_failed() is tells_nothing
