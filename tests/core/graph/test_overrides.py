"""Overrides are data: target, value, place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.errors import Place, UserError, did_you_mean
from graphnav.core.graph import Override, Target

NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
STAGES = st.lists(NAMES.filter(lambda name: name != "run"), min_size=1, max_size=3).map(tuple)
TARGETS = (
    st.builds(Target, st.sampled_from(["stage", "add"]), STAGES)
    | st.builds(Target, st.sampled_from(["setting", "wire"]), STAGES, NAMES)
    | st.builds(Target, st.just("run"), key=NAMES)
)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(st.characters(codec="utf-8"))


@given(TARGETS)
def test_a_target_reads_back_as_it_is_written(target: Target) -> None:
    assert Target.parse(str(target), Place("here")) == target
    assert {str(one) for one in target.each} == {
        str(Target(target.kind, (stage,), target.key)) for stage in target.stages
    } or target.kind == "run"


@given(TARGETS, SCALARS | st.lists(SCALARS, max_size=3))
def test_an_override_reads_back_as_it_is_written(target: Target, value: object) -> None:
    written = Override(target, value, Place("study.yaml", 3, 7))
    read = Override.parse(written.words)
    assert (read, type(read.value)) == (written, type(value))
    assert read.place == Place(f"--set {written.words}")


@pytest.mark.parametrize("text", ["", "plane", "=1", ".=1", "plane.=1", "run=1", "plane.rule+=1", "plane.rule=[1"])
def test_what_is_not_an_override_is_refused_at_its_text(text: str) -> None:
    with pytest.raises(UserError) as caught:
        Override.parse(text)
    assert [problem.place for problem in caught.value.problems] == [Place(f"--set {text}")]


def test_a_suggestion_is_a_field() -> None:
    error = UserError.of("there is no stage 'plan'", did_you_mean("plan", ["plane", "flow"]))
    assert (error.problems[0].kind, error.problems[0].suggestion) == ("unknown", "plane")
    assert str(error) == "there is no stage 'plan'\n  did you mean 'plane'?"
    assert not did_you_mean("x", ["plane"])
