"""The command line says studies, too, and changes those of files."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.errors import Problem, UserError
from graphnav.core.graph import Override
from graphnav.studies.ablation.study.command_line import study_of_command
from graphnav.studies.ablation.study.study import Choice, Study
from graphnav.studies.ablation.study.vary import parse_varies, split_values

FILE = """\
about: Which?
graphs: [corridor_ccw, pillars]
seeds: 0:3
set: [run.until_s=60, flow.layers=3]
vary:
  plane: [plane.ica, plane.affine]
  odometry:
    motion: {planar: planar.motion}
    subspace: {planar: planar.subspace}
  look:
    as it is: {}
    35 deg: {robot.tilt_deg: 35, planar.model: models/tilt_35.lcmlog}
  flow:
    lucas_kanade: {}
    dis fast: {flow: flow.dis, flow.preset: fast}
metrics: [drive.success]
"""


@pytest.fixture(autouse=True)
def _beside_a_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(FILE, encoding="utf-8")


def study(*varies: str, names: tuple[str, ...] = ("mine",), sets: tuple[str, ...] = ()) -> Study:
    return asked(names, varies=varies, sets=sets)


def asked(names: Sequence[str], *, varies: Sequence[str] = (), sets: Sequence[str] = (), **options: Any) -> Study:
    """Return the study of a command line with ``--vary`` and ``--set`` options."""
    problems: list[Problem] = []
    changes, overrides = parse_varies(varies, problems), Override.parse_all(sets, problems)
    return study_of_command(names, varies=changes, overrides=overrides, problems=problems, **options)


def sets_of(made: Study, axis: str) -> list[tuple[str, ...]]:
    return [words(choice.overrides) for choice in choices_of(made, axis)]


def words(overrides: Iterable[Override]) -> tuple[str, ...]:
    return tuple(override.words for override in overrides)


def choices_of(made: Study, axis: str) -> tuple[Choice, ...]:
    return next(a.choices for a in made.axes if a.name == axis)


def test_one_axis_is_asked_about_as_one() -> None:
    made = asked(["corridor_ccw"], varies=["plane=plane.ica,plane.affine"], seeds="0:2")
    assert made.about == "What does plane change on corridor_ccw?"


def test_a_study_of_graphs() -> None:
    made = asked(
        ["corridor_ccw", "pillars"],
        varies=["plane=plane.ica,plane.affine", "steer.sigma_ratio=0.125,0.25,0.50"],
        sets=["run.until_s=60"],
        metrics=["drive.success,drive.spl", "sight.auroc"],
        seeds="0:50",
        one_at_a_time=True,
    )
    assert (made.name, made.graphs) == ("corridor_ccw_pillars", ("corridor_ccw", "pillars"))
    assert made.about == "What do plane and steer.sigma_ratio change on corridor_ccw and pillars?"
    assert [axis.name for axis in made.axes] == ["plane", "steer.sigma_ratio"]
    assert sets_of(made, "steer.sigma_ratio")[-1] == ("steer.sigma_ratio=0.5",)
    assert (words(made.overrides), made.seeds, made.one_at_a_time) == (("run.until_s=60",), tuple(range(50)), True)
    assert made.metrics == ("drive.success", "drive.spl", "sight.auroc")


def test_a_study_says_the_same_in_a_file_and_on_the_command_line() -> None:
    text = "graph: pillars\nseeds: 0:3\nset: [run.until_s=9]\nmetrics: [a.b]\n"
    Path("file.yaml").write_text(f"{text}vary: {{plane: [a.b, c.d], x.y: [1e-3, [1, 2]]}}\n", encoding="utf-8")
    typed = asked(
        ["pillars"],
        varies=["plane=a.b,c.d", "x.y=1e-3,[1, 2]"],
        sets=["run.until_s=9"],
        metrics=["a.b"],
        seeds="[0, 1, 2]",
    )
    read = asked(["file"])
    assert (read.graphs, read.axes, read.seeds) == (typed.graphs, typed.axes, typed.seeds)
    assert read.overrides == typed.overrides
    assert read.metrics == typed.metrics


def test_a_file_alone_is_as_it_is() -> None:
    made = study()
    assert (made.name, made.about, made.seeds) == ("mine", "Which?", (0, 1, 2))
    assert [axis.name for axis in made.axes] == ["plane", "odometry", "look", "flow"]


def test_options_come_before_the_file() -> None:
    made = asked(["mine"], seeds="5:7", metrics=["sight.auroc"], one_at_a_time=True)
    assert (made.seeds, made.metrics, made.one_at_a_time) == ((5, 6), ("sight.auroc",), True)


def test_set_replaces_what_the_file_sets_of_the_same() -> None:
    assert words(study(sets=("run.until_s=5", "steer.gain=2")).overrides) == (
        "flow.layers=3",
        "run.until_s=5",
        "steer.gain=2",
    )


def test_a_detector_of_ones_own_enters_by_one_option() -> None:
    made = study("plane+=plane.mine")
    assert sets_of(made, "plane") == [("plane=plane.ica",), ("plane=plane.affine",), ("plane=plane.mine",)]
    assert choices_of(made, "plane")[-1].label == "plane.mine"


def test_several_may_enter() -> None:
    assert sets_of(study("plane+=plane.a,plane.b", "plane+=plane.c"), "plane")[2:] == [
        ("plane=plane.a",),
        ("plane=plane.b",),
        ("plane=plane.c",),
    ]


def test_an_axis_is_replaced_in_its_place_and_a_new_one_comes_last() -> None:
    made = study("plane=plane.affine,plane.truth", "steer=steer.pca,steer.balance")
    assert [axis.name for axis in made.axes] == ["plane", "odometry", "look", "flow", "steer"]
    assert sets_of(made, "plane") == [("plane=plane.affine",), ("plane=plane.truth",)]


def test_an_axis_with_labels_keeps_those_that_are_named() -> None:
    made = study("look=35 deg", "odometry=subspace,motion")
    assert [c.label for c in choices_of(made, "look")] == ["35 deg"]
    assert [c.label for c in choices_of(made, "odometry")] == ["subspace", "motion"]


@pytest.mark.parametrize(
    ("option", "axis", "sets"),
    [
        ("odometry+=planar.gain", "odometry", ("planar=planar.gain",)),  # all its choices set planar
        ("planar+=planar.gain", "odometry", ("planar=planar.gain",)),  # and it is the only axis that does
        ("flow+=flow.farneback", "flow", ("flow=flow.farneback",)),  # the one stage that it swaps
        ("look+=robot.tilt_deg=20", "look", ("robot.tilt_deg=20",)),  # said
    ],
)
def test_labelled_axes_grow_where_it_is_clear_what_is_meant(option: str, axis: str, sets: tuple[str, ...]) -> None:
    made = choices_of(study(option), axis)
    assert words(made[-1].overrides) == sets
    assert len(made) == 3


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("look+=20", "sets robot.tilt_deg, planar.model: it is not clear"),
        ("look=20 deg", "has no choice '20 deg'\n  it has as it is, 35 deg"),
        ("plane+=plane.ica", "axis 'plane' has plane.ica twice"),
        ("odometry+=planar.motion", "planar.motion is the same as motion"),
        ("stear+=steer.pca", "there is no axis 'stear' to add to"),
        ("plan+=plane.mine", "did you mean 'plane'?"),
        ("=a,b", "does not name an axis"),
        ("+=a", "does not name an axis"),
        ("seed=1,2", "results have a column of that name"),
    ],
)
def test_what_is_wrong_is_said_with_the_option(option: str, said: str) -> None:
    with pytest.raises(UserError) as caught:
        study(option)
    assert str(caught.value).startswith(f"--vary {option}: ")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a,b", ["a", "b"]),
        ("[1,2],[3,4]", ["[1,2]", "[3,4]"]),
        ("[[1,2],[3]],5", ["[[1,2],[3]]", "5"]),
        ('"a,b",c', ['"a,b"', "c"]),
        ("'a,b',c", ["'a,b'", "c"]),
        ("{a: 1, b: 2},c", ["{a: 1, b: 2}", "c"]),
        ("[1,2", ["[1,2"]),
        ("1],2", ["1]", "2"]),
        ('"a,b', ['"a,b']),
        ("don't,won't", ["don't", "won't"]),
        ("", [""]),
        ("a,", ["a", ""]),
    ],
)
def test_commas_in_brackets_and_quotes_do_not_split(text: str, values: list[str]) -> None:
    assert list(split_values(text)) == values
