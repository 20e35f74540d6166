"""A study file is read with strings and numbers as they were written."""

import math
from collections.abc import Iterable
from pathlib import Path

import pytest

from graphnav.core.errors import Place, UserError
from graphnav.core.graph import Override, shipped_folder, shipped_graphs
from graphnav.studies.ablation.study.find_study import classify, find, shipped_studies
from graphnav.studies.ablation.study.study import Axis
from graphnav.studies.ablation.study.study_file import load_study

GRAPH = "stages: {}\n"


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def axes_of(vary: str) -> tuple[Axis, ...]:
    Path("study.yaml").write_text(f"graph: corridor_ccw\nvary:\n{vary}", encoding="utf-8")
    return load_study("study").axes


def sets_of(vary: str) -> list[dict[str, object]]:
    return [set_by(choice.overrides) for axis in axes_of(vary) for choice in axis.choices]


def set_by(overrides: Iterable[Override]) -> dict[str, object]:
    return {str(override.target): override.value for override in overrides}


def labels_of(vary: str) -> list[str]:
    return [choice.label for axis in axes_of(vary) for choice in axis.choices]


def test_all_that_a_study_can_say() -> None:
    Path("mine.yaml").write_text(
        "about: Which?\ngraphs: [corridor_ccw, pillars]\nseeds: 1000:1003\none_at_a_time: true\n"
        "set: [run.until_s=60]\nvary: {plane: [plane.ica, plane.affine]}\nmetrics: [drive.success]\n",
        encoding="utf-8",
    )
    study = load_study("mine")
    assert (study.name, study.about, study.graphs) == ("mine", "Which?", ("corridor_ccw", "pillars"))
    assert (study.seeds, study.one_at_a_time) == ((1000, 1001, 1002), True)
    assert (set_by(study.overrides), study.metrics) == ({"run.until_s": 60}, ("drive.success",))
    assert [axis.name for axis in study.axes] == ["plane"]
    assert study.places["drive.success"] == Place("mine.yaml", 7, 11)


def test_what_may_be_left_out() -> None:
    Path("mine.yaml").write_text("graph: pillars\nvary: {plane: [plane.ica]}\n", encoding="utf-8")
    study = load_study("mine.yaml")
    assert (study.about, study.seeds, study.overrides, study.metrics, study.one_at_a_time) == ("", (), (), (), False)


def test_set_may_be_a_mapping() -> None:
    text = "graph: pillars\nset: {run.until_s: 60, steer.near_weight: .5}\nvary: {plane: [plane.ica]}\n"
    Path("mine.yaml").write_text(text, encoding="utf-8")
    assert set_by(load_study("mine").overrides) == {"run.until_s": 60, "steer.near_weight": 0.5}


def test_a_stage_is_called_by_what_it_becomes_all_else_with_its_target() -> None:
    assert (
        labels_of("  plane: [plane.ica, plane.affine]\n  plane,twin: [plane.ica, plane.affine]\n")
        == [
            "plane.ica",
            "plane.affine",
        ]
        * 2
    )
    assert labels_of("  steer.sigma_ratio: [0.5]\n  plane.in.flow: [flow.flow]\n  run.until_s: [60]\n") == [
        "steer.sigma_ratio=0.5",
        "plane.in.flow=flow.flow",
        "run.until_s=60",
    ]


@pytest.mark.parametrize(
    ("written", "value", "label"),
    [
        ("0.125", 0.125, "0.125"),
        ("0.50", 0.5, "0.50"),
        ("1e-3", 1e-3, "1e-3"),
        ("1E+3", 1e3, "1E+3"),
        ("0x10", 16, "0x10"),
        ("+7", 7, "+7"),
        ("-.5", -0.5, "-.5"),
        (".inf", math.inf, ".inf"),
        ("true", True, "true"),
        ("False", False, "false"),
        ("null", None, "null"),
        ("~", None, "null"),
        ("otsu", "otsu", "otsu"),
        ("on", "on", "on"),
        ("'1e3'", "1e3", "1e3"),
        ("''", "", ""),
        ("'[a'", "[a", "[a"),
        ("'two words, and a comma'", "two words, and a comma", "two words, and a comma"),
        ("rtsp://robot:8554/eye", "rtsp://robot:8554/eye", "rtsp://robot:8554/eye"),
        ("Größe", "Größe", "Größe"),
        ('"a\\nb"', "a\nb", '"a\\u000ab"'),
        ("[0.50, 1e1, [a, 'b, c']]", [0.5, 10.0, ["a", "b, c"]], '[0.50, 1e1, [a, "b, c"]]'),
        ("&anchor 0.50", 0.5, "0.5"),
        ("!!str 5", "5", "5"),
    ],
)
def test_values_keep_their_type_and_labels_what_was_written(written: str, value: object, label: str) -> None:
    (found,) = sets_of(f"  toy.value:\n  - {written}\n")
    assert (found["toy.value"], type(found["toy.value"])) == (value, type(value))
    assert labels_of(f"  toy.value:\n  - {written}\n") == [f"toy.value={label}"]
    assert sets_of(f"  toy: {{a: {{toy.value: {written}}}}}\n") == [found]


def test_an_alias_means_what_it_stands_for() -> None:
    assert sets_of("  a.b: [&x 0.5, 1]\n  c.d: [*x]\n") == [{"a.b": 0.5}, {"a.b": 1}, {"c.d": 0.5}]


def test_a_named_axis() -> None:
    tilt, odometry = axes_of(
        "  tilt:\n    75°, as taught: {}\n    nothing:\n      # only a remark\n"
        "    '35': {robot.tilt_deg: 35, planar.model: models/tilt_35.lcmlog}\n"
        "  odometry: {motion: {planar: planar.motion}, subspace: {planar: planar.subspace}}\n".replace(
            "    nothing:\n      # only a remark\n", ""
        )
    )
    assert [choice.label for choice in tilt.choices] == ["75°, as taught", "35"]
    assert [set_by(choice.overrides) for choice in tilt.choices] == [
        {},
        {"robot.tilt_deg": 35, "planar.model": "models/tilt_35.lcmlog"},
    ]
    assert [set_by(c.overrides) for c in odometry.choices] == [
        {"planar": "planar.motion"},
        {"planar": "planar.subspace"},
    ]


def test_a_label_with_nothing_behind_it_means_the_graph_as_it_is() -> None:
    assert sets_of("  tilt:\n    usual:\n    low: {robot.tilt_deg: 20}\n") == [{}, {"robot.tilt_deg": 20}]


def test_every_choice_and_every_set_has_its_place() -> None:
    plane, tilt = axes_of("  plane: [plane.ica,\n    plane.affine]\n  tilt:\n    low: {a.b: 1, c.d: 2}\n")
    assert (plane.place, plane.choices[1].overrides[0].place) == (Place("study.yaml", 3, 3), Place("study.yaml", 4, 5))
    assert tilt.choices[0].place == Place("study.yaml", 6, 5)
    assert [o.place for o in tilt.choices[0].overrides] == [Place("study.yaml", 6, 16), Place("study.yaml", 6, 24)]


def test_graphs_beside_the_study_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "lab").mkdir()
    for name in ("lab/pillars.yaml", "lab/own.yml", "elsewhere.yaml"):
        Path(name).write_text(GRAPH, encoding="utf-8")
    text = "graphs: [pillars, own, elsewhere, corridor_cw]\nvary: {plane: [plane.ica]}\n"
    Path("lab/study.yaml").write_text(text, encoding="utf-8")
    assert load_study("lab/study").graphs == ("lab/pillars.yaml", "lab/own.yml", "elsewhere", "corridor_cw")
    monkeypatch.chdir("lab")
    Path("elsewhere.yaml").write_text(GRAPH, encoding="utf-8")
    assert load_study("study").graphs == ("pillars", "own", "elsewhere", "corridor_cw")


def test_a_study_is_not_its_own_graph() -> None:
    Path("pillars.yaml").write_text("graph: pillars\nvary: {plane: [plane.ica]}\n", encoding="utf-8")
    Path("lab").mkdir()
    Path("pillars.yaml").rename("lab/pillars.yaml")
    assert load_study("lab/pillars.yaml").graphs == ("pillars",)


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b", "/", ".", "..", ""])
def test_graphs_that_cannot_be_files(name: str) -> None:
    escaped = name.replace("\0", "\\0")
    Path("study.yaml").write_text(f'graph: "{escaped}"\nvary: {{plane: [plane.ica]}}\n', encoding="utf-8")
    with pytest.raises(UserError):
        load_study("study")


@pytest.mark.parametrize("name", sorted(shipped_studies()))
def test_studies_that_ship_can_be_read(name: str) -> None:
    assert classify(name) == "study"
    study = load_study(name)
    assert study.name == name
    assert study.about.endswith("?")
    assert study.metrics


@pytest.mark.parametrize("name", sorted(shipped_graphs()))
def test_graphs_that_ship_are_no_studies(name: str) -> None:
    assert classify(name) == "graph"


def test_studies_and_graphs_are_told_apart_by_what_they_say() -> None:
    for name, text, kind in (
        ("a", "vary: {}", "study"),
        ("b", "stages: {}", "graph"),
        ("c", "graphs: []", "study"),
        ("d", "about: nothing yet", "graph"),
        ("e", "stages: {}\nvary: {}", "study"),
        ("f", "[1, 2]", "study"),
    ):
        Path(f"{name}.yaml").write_text(text, encoding="utf-8")
        assert classify(name) == kind, text


def test_what_lies_in_the_working_folder_comes_before_what_ships() -> None:
    shipped = shipped_folder() / "studies" / "detectors.yaml"
    assert find("detectors") == shipped
    Path("detectors").mkdir()
    assert find("detectors") == shipped
    Path("detectors.yaml").touch()
    assert find("detectors") == Path("detectors.yaml")


@pytest.mark.parametrize("name", ["nowhere", "a/b", "x" * 5000, "a\0b"])
def test_what_is_not_there(name: str) -> None:
    with pytest.raises(UserError, match="there is no such study or graph"):
        find(name)


def test_a_folder_is_said_to_be_one() -> None:
    Path("lab").mkdir()
    with pytest.raises(UserError, match="it is a folder"):
        find("lab")
