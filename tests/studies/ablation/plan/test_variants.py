"""Axes cross to all combinations, or change one at a time; every variant has a name of its own."""

import itertools
import math
from dataclasses import replace

import pytest

from graphnav.core.errors import UserError
from graphnav.core.graph import Override
from graphnav.studies.ablation.plan.variants import MAX_CASES, count_variants, expand
from graphnav.studies.ablation.study.study import Axis, Choice, Study


def axis(name: str, *labels: str) -> Axis:
    return Axis(name, tuple(Choice(label, (Override.parse(f"{name}={label}"),)) for label in labels))


def study(*axes: Axis, one_at_a_time: bool = False, graphs: tuple[str, ...] = ("g",)) -> Study:
    return Study("s", "", graphs, axes, (0,), one_at_a_time=one_at_a_time)


PLANE, FLOW, TILT = axis("plane", "ica", "affine", "truth"), axis("flow", "lk", "dis"), axis("tilt", "75", "35", "20")
SHAPES = ([PLANE], [PLANE, FLOW], [PLANE, FLOW, TILT], [axis("plane", "ica")], [axis("a", "x"), TILT])


@pytest.mark.parametrize("axes", SHAPES)
@pytest.mark.parametrize("one_at_a_time", [False, True])
def test_variants_are_all_there_once_the_base_first(axes: list[Axis], one_at_a_time: bool) -> None:
    asked = study(*axes, one_at_a_time=one_at_a_time)
    variants = expand(asked)
    assert len(variants) == count_variants(asked)
    assert len({v.name for v in variants}) == len(variants)
    assert len({tuple(v.labels.values()) for v in variants}) == len(variants)
    assert [v.is_base for v in variants] == [True] + [False] * (len(variants) - 1)
    assert variants[0].labels == {a.name: a.choices[0].label for a in axes}
    assert all(list(v.labels) == [a.name for a in axes] for v in variants)


@pytest.mark.parametrize("axes", SHAPES)
def test_crossed_axes_make_every_combination(axes: list[Axis]) -> None:
    made = {tuple(v.labels.values()) for v in expand(study(*axes))}
    assert made == set(itertools.product(*([c.label for c in a.choices] for a in axes)))
    assert len(made) == math.prod(len(a.choices) for a in axes)


@pytest.mark.parametrize("axes", SHAPES)
def test_one_at_a_time_changes_one_axis(axes: list[Axis]) -> None:
    base, *others = expand(study(*axes, one_at_a_time=True))
    for variant in others:
        assert sum(variant.labels[name] != base.labels[name] for name in base.labels) == 1


def test_names() -> None:
    assert [v.name for v in expand(study(PLANE))] == ["ica", "affine", "truth"]
    assert [v.name for v in expand(study(PLANE, one_at_a_time=True))] == ["ica", "affine", "truth"]
    assert [v.name for v in expand(study(FLOW, axis("tilt", "75", "35")))] == [
        "lk + 75",
        "lk + 35",
        "dis + 75",
        "dis + 35",
    ]
    assert [v.name for v in expand(study(FLOW, TILT, one_at_a_time=True))] == ["base", "dis", "35", "20"]


def test_within_conditions_every_one_has_its_base() -> None:
    asked = replace(study(PLANE, axis("tilt", "75", "35"), FLOW), within=("tilt",))
    variants = expand(asked)
    assert [(v.condition, v.called, v.is_base) for v in variants[::3]] == [
        ("75", "ica + lk", True),
        ("75", "affine + dis", False),
        ("35", "ica + lk", True),
        ("35", "affine + dis", False),
    ]
    assert {v.name for v in variants} == {v.name for v in expand(replace(asked, within=()))}
    assert sum(v.is_base for v in variants) == 2


def test_two_conditions_cross() -> None:
    asked = replace(study(axis("tilt", "75", "35"), PLANE, axis("noise", "0", "2")), within=("noise", "tilt"))
    assert list(dict.fromkeys(v.condition for v in expand(asked))) == ["75 + 0", "75 + 2", "35 + 0", "35 + 2"]


def test_names_say_the_axis_where_two_have_the_same_choice() -> None:
    twins = study(axis("plane", "ica", "affine"), axis("twin", "ica", "affine"), one_at_a_time=True)
    assert [v.name for v in expand(twins)] == ["base", "plane=affine", "twin=affine"]


def test_names_that_would_read_the_same_are_numbered() -> None:
    hard = study(axis("one", "a", "a + b"), axis("two", "b + c", "c"))
    assert [v.name for v in expand(hard)] == ["a + b + c", "a + c", "a + b + b + c", "a + b + c (2)"]
    assert [v.name for v in expand(study(PLANE, axis("x", "y", "base"), one_at_a_time=True))][-1] == "base (2)"


def test_overrides_come_in_the_order_of_the_axes() -> None:
    assert [o.words for o in expand(study(PLANE, FLOW))[-1].overrides] == ["plane=truth", "flow=dis"]


def test_too_many_are_refused_before_they_are_made() -> None:
    digits = [axis(f"axis{number}", *map(str, range(100))) for number in range(100)]
    with pytest.raises(UserError, match=r"cross to more than 10\^12 variants: more than 2000"):
        expand(study(*digits))
    with pytest.raises(UserError, match=r"have 9901 variants: .*\n  take fewer values"):
        expand(study(*digits, one_at_a_time=True))


def test_graphs_count() -> None:
    at_limit = axis("noise", *map(str, range(MAX_CASES // 2)))
    assert len(expand(study(at_limit, graphs=("a", "b")))) == MAX_CASES // 2
    with pytest.raises(UserError, match="1000 variants on 3 graphs"):
        expand(study(at_limit, graphs=("a", "b", "c")))
