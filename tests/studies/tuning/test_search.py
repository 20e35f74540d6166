"""Which parameters are searched, and from where."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import graphnav
from graphnav import UserError
from graphnav.studies.tuning import Trial, parse_searches
from graphnav.studies.tuning.tuning_run import propose

from .conftest import GRAPH

METRICS: Any = {"score.hit": "higher"}
TWINS = GRAPH.replace("  score", "  twin:  {use: aim.near, in: {twist: clock}}\n  score")


@pytest.mark.parametrize("default", [None, "auto", [1.0, 2.0]])
def test_a_default_that_has_no_place_in_the_range_is_no_obstacle(default: object) -> None:
    space = parse_searches(["aim.bell=0.1:1", "aim.gain=1:4"], [])
    tried = [Trial("A", 0, {}, {"score.hit": {("g", 0): 1.0}})]
    found = propose(space, {"aim.bell": default, "aim.gain": 2.0}, tried, METRICS, 2, 0)
    assert all(0.1 <= params["aim.bell"] <= 1 for params in found)


def test_a_default_beyond_the_choices_is_not_taken_for_the_first_one() -> None:
    space = parse_searches(["aim.mode=coarse,fine", "aim.gain=1:4"], [])
    tried = [Trial("A", 0, {}, {"score.hit": {("g", 0): 1.0}})]
    known = [
        propose(space, {"aim.mode": mode, "aim.gain": 2.0}, tried * 12, METRICS, 1, 0) for mode in ("rough", "coarse")
    ]
    assert known[0] != known[1]


def test_a_parameter_that_is_null_may_be_searched(aim: dict[str, Any]) -> None:
    tuned = graphnav.tune(**aim | {"trials": 7}, search=["aim.far=0.5:4"])
    assert len([trial for trial in tuned.trials if trial.params]) == 6
    assert all(trial.params["aim.far"] >= 0.5 for trial in tuned.trials if trial.params)


def test_a_range_of_one_stage_takes_the_place_of_that_of_several(aim: dict[str, Any]) -> None:
    Path("aim.yaml").write_text(TWINS)
    rivals = {"vary": {"aim,twin": ["aim.near", "aim.fixed"]}, "trials": 3}
    tuned = graphnav.tune(**aim | rivals, search=["aim.gain=1:3"])
    texts = [one.text for one in tuned.run.tuning.rivals[0].space]
    assert texts == ["aim,twin.mode=coarse,fine", "aim,twin.steps=1:8", "aim.gain=1:3"]
    assert not any(trial.refused for trial in tuned.trials)


def test_two_ranges_of_one_stage_are_an_error(aim: dict[str, Any]) -> None:
    Path("aim.yaml").write_text(TWINS)
    with pytest.raises(UserError, match=r"'aim.gain' is searched twice, first by 'aim,twin.gain=2:3'"):
        graphnav.tune(**aim, search=["aim,twin.gain=2:3", "aim.gain=1:3"])


def test_stages_that_are_swapped_alone_and_together_are_searched_once(aim: dict[str, Any]) -> None:
    Path("aim.yaml").write_text(TWINS)
    Path("rivals.yaml").write_text(
        "graph: aim\nseeds: 0:2\nmetrics: [score.miss_m]\n"
        "vary:\n  who:\n    one: {aim: aim.near}\n    both: {'aim,twin': aim.near}\n"
    )
    tuned = graphnav.tune("rivals.yaml", trials=2, plugins=aim["plugins"], jobs=1)
    assert not any(trial.refused for trial in tuned.trials)


def test_all_errors_of_ranges_are_reported(aim: dict[str, Any]) -> None:
    with pytest.raises(UserError) as caught:
        graphnav.tune(**aim, search=["aim.gain=2:1", "aim=3", "aim.steps=1:2", "aim.steps=1:3"])
    text = str(caught.value)
    assert "the range ends at 1" in text
    assert "this does not name a parameter" in text
    assert "'aim.steps' is searched twice" in text
