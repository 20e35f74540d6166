"""The JSON Schema accepts every graph that loads and refuses those that a schema can refuse."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.graph import graph_schema, shipped_folder, shipped_graphs
from graphnav.core.spec import parse_yaml

TESTS = Path(__file__).parent.parent
ERRORS = TESTS / "errors"
BROKEN_MAPS = TESTS / "plugins" / "world" / "broken_maps"
GRAPHS = {path.stem: path for path in ERRORS.glob("*/*.yaml") if path.parent.name != "studies"}
"""The broken graphs, by name."""

REFUSED = """
inputs_were_queues inputs_a_list input_channel_names outputs_wrong output_channel_names queues_wrong times_wrong
channel_name_empty channel_name_reserved channel_name_too_long channel_name_with_space deploy_wrong empty
inputs_wrong key_not_a_text many missing_parameter not_a_choice not_a_mapping only_a_text out_of_bounds
reference_not_a_text seed_wrong stage_a_text stage_empty stage_name_wrong stages_a_list stages_empty stages_missing
stage_without_family unconnected_input unconnected_input_with_choice unconnected_input_without_writer
family_without_stage unknown_family unknown_input unknown_key unknown_parameter unknown_parameter_far_from_all
unknown_run_key unknown_stage unknown_stage_key use_missing use_not_a_text whole_number_expected with_not_a_mapping
wrong_length wrong_type yes_is_a_text number_in_quotes only_a_comment
""".split()  # noqa: SIM905
"""The broken graphs in which a word, not the meaning of the wires, is wrong."""

WIRED = """
ambiguous_swap deploy_stages input_log_missing input_of_another_type loop motor_without_guard motor_without_timer
twist_without_motor two_writers type_mismatch unknown_reference
""".split()  # noqa: SIM905
"""Those in which every word is right by itself."""


@pytest.fixture(scope="module")
def toy_schema(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return the schema of graphs of the toys, without those that are declared wrongly."""
    path = tmp_path_factory.mktemp("toys") / "toys.py"
    path.write_text(
        (ERRORS / "stages.py").read_text().replace("Idle,", "").replace("Eager,", "").replace("Untyped,", "")
    )
    catalog = Catalog()
    catalog.add_file(path)
    return graph_schema(catalog)


def plain(path: Path) -> Any:
    return parse_yaml(path.read_bytes(), path.name)[0].plain()


def is_valid(graph: Any, schema: dict[str, Any]) -> bool:
    return bool(jsonschema.Draft202012Validator(schema).is_valid(graph))


def test_the_command_prints_a_valid_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    jsonschema.Draft202012Validator.check_schema(schema)
    for name, path in shipped_graphs().items():
        assert is_valid(plain(path), schema), name


def test_a_camera_may_be_given_by_its_bare_number() -> None:
    graph = {"stages": {"camera": {"use": "io.video", "with": {"path": 0}}}}
    assert is_valid(graph, graph_schema(Catalog()))


@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_word_is_refused(toy_schema: dict[str, Any], case: str) -> None:
    assert not is_valid(plain(GRAPHS[case]), toy_schema)


@pytest.mark.parametrize(
    "case", ["extends_list", "extends_a_mapping", "plugins_not_a_list", "plugins_wrong", "extends_stage_a_text"]
)
def test_a_wrong_word_of_several_files_is_refused(toy_schema: dict[str, Any], case: str) -> None:
    assert not is_valid(plain(GRAPHS[case]), toy_schema)


EXTENDS = {
    "extends": "corridor_ccw",
    "plugins": ["mine.py"],
    "stages": {
        "plane": {"use": "mine.detector"},
        "flow": {"with": {"layers": 2}, "in": {"goal": None}, "every_ms": None, "deadline_ms": 20},
        "sight": None,
    },
    "channels": {"robot.image": None, "plane.plane": "PLANE"},
    "inputs": {"camera.image": {"max_age_s": 0.3, "channel": None}, "base.odometry": None},
    "outputs": {"guard.twist": {"channel": "BASE", "stop": None}, "control.twist": None},
    "queues": {"plane.flow": None, "plane.planar": {"keep": 2}},
}


def test_a_graph_that_extends_another_says_only_what_differs(toy_schema: dict[str, Any]) -> None:
    assert is_valid(EXTENDS, toy_schema)
    assert is_valid({"extends": "corridor_ccw"}, toy_schema)
    assert is_valid({"extends": ["corridor_ccw", "parts/navigate"]}, toy_schema)
    assert not is_valid({"extends": []}, toy_schema)
    assert not is_valid({key: word for key, word in EXTENDS.items() if key != "extends"}, toy_schema)
    assert not is_valid(EXTENDS | {"channels": {"robot.image": 3}}, toy_schema)
    assert not is_valid(EXTENDS | {"inputs": {"camera.image": {"max_age_s": 0}}}, toy_schema)
    assert not is_valid(EXTENDS | {"stages": {"plane": {"uses": "mine.detector"}}}, toy_schema)


@pytest.mark.parametrize(
    ("words", "right", "wrong"),
    [
        ({"stages": {"plane": {"every_ms": "?"}}}, [1, 60_000], [0.5, 60_001]),
        ({"inputs": {"camera.image": {"max_age_s": "?"}}}, [0.1, 60], [0, 60.5]),
        ({"outputs": {"guard.twist": {"max_age_s": "?"}}}, [0.1, 5], [0, 5.5]),
    ],
)
def test_times_and_ages_have_bounds(words: dict[str, Any], right: list[float], wrong: list[float]) -> None:
    schema, text = graph_schema(Catalog()), json.dumps({"extends": "corridor_ccw", **words})
    for number in right:
        assert is_valid(json.loads(text.replace('"?"', str(number))), schema)
    for number in wrong:
        assert not is_valid(json.loads(text.replace('"?"', str(number))), schema)


def test_ages_of_the_guard_have_bounds() -> None:
    params = graph_schema(Catalog())["$defs"]["control.guard"]["properties"]["with"]["properties"]
    bounds = {"max_age_s": 10.0, "override_max_age_s": 5.0}
    assert {name: params[name]["maximum"] for name in bounds} == bounds


def test_stages_of_plugins_may_be_any(toy_schema: dict[str, Any]) -> None:
    graph = {"stages": {"robot": {"use": "toy.robot"}, "mine": {"use": "mine.detector", "in": {"flow": "robot.image"}}}}
    assert not is_valid(graph, toy_schema)
    assert is_valid(graph | {"plugins": ["mine.py"]}, toy_schema)
    wrong = {"stages": {"robot": {"use": "toy.robot", "with": {"noise": 1}}}, "plugins": ["mine.py"]}
    assert not is_valid(wrong, toy_schema), "stages that are known are checked"


@pytest.mark.parametrize("case", WIRED)
def test_what_only_the_wires_tell_is_left_to_the_check(toy_schema: dict[str, Any], case: str) -> None:
    assert is_valid(plain(GRAPHS[case]), toy_schema)


def test_words_are_described_for_editors(toy_schema: dict[str, Any]) -> None:
    params = toy_schema["$defs"]["toy.matcher"]["properties"]["with"]["properties"]
    assert params["layers"] == {
        "type": "integer", "description": "layers of the pyramid", "minimum": 1, "maximum": 8, "default": 3,
    }  # fmt: skip


NOT_YAML = "alias bad_yaml deep not_utf8 repeated_key two_documents no_yaml label_a_number".split()  # noqa: SIM905
"""Refused by the reader of YAML before any schema is asked."""

MAPS_THAT_ONLY_DRAWING_REFUSES = """
barn_and_a_ring barn_moving_and_barn corridor_wider_than_its_bend door_beyond_its_wall gap_too_narrow moves_and_crosses
no_path pillar_larger_than_field start_inside_a_wall start_inside_an_obstacle start_without_value straight_way_is_free
too_large too_many_pillars too_thick_for_its_bend
""".split()  # noqa: SIM905
"""Right by themselves, but not together: what touches, crosses, leaves no way, does not fit, or begins nowhere."""

STUDIES_THAT_A_SCHEMA_REFUSES = """
axis_a_text former_names graph_and_graphs graph_empty graphs_of_all_kinds key_unknown no_graphs nothing_varies
seeds_negative seeds_of_all_kinds seeds_one_number study_a_list types value_a_mapping vary_a_list within_a_mapping
""".split()  # noqa: SIM905
"""Wrong in themselves. What the others name (graphs, stages, axes, metrics) or repeat, no schema of the file knows."""


def schema_of(name: str, capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, Any]:
    assert main(["schema", "--of", name, *options]) == 0
    schema: dict[str, Any] = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(schema)
    return schema


@pytest.mark.parametrize(("name", "folder"), [("map", "maps"), ("study", "studies")])
def test_files_that_ship_are_valid(name: str, folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    schema = schema_of(name, capsys)
    files = sorted((shipped_folder() / folder).glob("*.yaml"))
    assert files
    for path in files:
        assert is_valid(plain(path), schema), path.name


def test_broken_maps_are_refused_but_those_that_have_to_be_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    schema = schema_of("map", capsys)
    cases = [path for path in sorted(BROKEN_MAPS.glob("*.yaml")) if path.stem not in NOT_YAML]
    valid = [path.stem for path in cases if is_valid(plain(path), schema)]
    assert valid == MAPS_THAT_ONLY_DRAWING_REFUSES


def test_broken_studies_are_refused_where_the_file_alone_is_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    schema = schema_of("study", capsys)
    cases = [path for path in sorted((ERRORS / "studies").glob("*.yaml")) if path.stem not in NOT_YAML]
    studies = [path for path in cases if isinstance(plain(path), dict | list)]
    refused = [path.stem for path in studies if not is_valid(plain(path), schema)]
    assert refused == STUDIES_THAT_A_SCHEMA_REFUSES


NOTES = """
from graphnav import FileFormat, Record, hookimpl, key

class Notes(Record):
    noun = "a book of notes"
    lines: tuple[str, ...] = key(min_items=1, doc="what was noted")

@hookimpl
def graphnav_file_formats():
    return [FileFormat(%s, Notes, title="Notes", doc="")]
"""


def test_a_plugin_offers_a_format_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plugin = tmp_path / "notes.py"
    plugin.write_text(NOTES % "'notes'")
    schema = schema_of("notes", capsys, "--plugin", str(plugin))
    assert is_valid({"lines": ["a"]}, schema)
    assert not is_valid({"lines": []}, schema)


@pytest.mark.parametrize(
    ("hook", "said"),
    [
        (NOTES % "'map'", "there is another file format 'map'"),
        (NOTES.replace("[FileFormat", "5 or [FileFormat") % "'notes'", "does not return a list of FileFormat"),
    ],
)
def test_a_format_that_cannot_be_offered(
    hook: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plugin = tmp_path / "notes.py"
    plugin.write_text(hook)
    assert main(["schema", "--of", "map", "--plugin", str(plugin)]) == 2
    assert said in capsys.readouterr().err


def test_an_unknown_format_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "--of", "mapp"]) == 2
    assert capsys.readouterr().err == "--of: there is no file format 'mapp'\n  did you mean 'map'?\n"
