"""A problem that a user is told of."""

import pytest

from graphnav import Problem
from graphnav.core.errors import did_you_mean


def test_a_problem_cannot_be_changed() -> None:
    problem = Problem(None, "no stage 'flwo'", did_you_mean("flwo", ["flow"]))
    with pytest.raises(AttributeError, match="'what'"):
        problem.what = "another"
    assert problem.what == "no stage 'flwo'"


def test_a_near_name_makes_a_problem_one_of_an_unknown_name() -> None:
    assert Problem(None, "no stage 'flwo'", did_you_mean("flwo", ["flow"])).kind == "unknown"
    assert Problem(None, "no stage 'flwo'", "write one").kind == "wrong"
    assert Problem(None, "two", did_you_mean("flwo", ["flow"]), "duplicate").kind == "duplicate"
