"""Paths to parts of messages pick the same elements as numpy, and wrong paths are refused."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import graphnav_lcm
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.cli import main
from graphnav.core.codec import codec_of, encode
from graphnav.core.errors import UserError
from graphnav.core.messages import Flow, GuardState, State, Twist
from graphnav.core.record import LogWriter
from graphnav.watch.fields.field_columns import Selection, all_columns, columns_of
from graphnav.watch.fields.field_path import MISSING, parse_field

ARRAY = np.arange(24).reshape(2, 3, 4)
INDEX = st.one_of(
    st.integers(-5, 5),
    st.builds(slice, st.none() | st.integers(-5, 5), st.none() | st.integers(-5, 5), st.none() | st.integers(1, 3)),
)


def written(index: int | slice) -> str:
    if isinstance(index, int):
        return f"[{index}]"
    start, stop, step = ("" if part is None else part for part in (index.start, index.stop, index.step))
    return f"[{start}:{stop}:{step}]" if step else f"[{start}:{stop}]"


@given(st.lists(INDEX, max_size=3))
def test_picks_what_numpy_picks(indices: list[int | slice]) -> None:
    picked = parse_field("a.b" + "".join(map(written, indices))).pick({"a": {"b": ARRAY}})
    try:
        wanted = ARRAY[tuple(indices)]
    except IndexError:
        assert picked is MISSING
        return
    assert np.array_equal(picked, wanted)
    assert isinstance(picked, np.ndarray) == (np.ndim(wanted) > 0)


@given(st.text(max_size=20))
def test_any_text_is_a_path_or_a_users_error(text: str) -> None:
    try:
        path = parse_field(text)
    except UserError:
        return
    assert path.text == text


@pytest.mark.parametrize(
    "text", ["", ".", "a.", "a[", "a[]", "a[x]", "a[1,2]", "a[::0]", "a[1]b", "1a", "a b", "a[9999999999]"]
)
def test_what_is_no_path_is_said(text: str) -> None:
    with pytest.raises(UserError) as caught:
        parse_field(text)
    wanted = f"--field: '{text}' is not a path to a field\n  write a.b, a[0], a[0][1] or a[2:8]"
    assert str(caught.value) == wanted


@pytest.mark.parametrize(
    ("lcm_class", "path", "said"),
    [
        (graphnav_lcm.twist_t, "v_mp", "graphnav_lcm.twist_t has no field 'v_mp'\n  did you mean 'v_mps'?"),
        (
            graphnav_lcm.twist_t,
            "zebra",
            "graphnav_lcm.twist_t has no field 'zebra'\n  its fields are utime, seq, v_mps, omega_radps",
        ),
        (
            graphnav_lcm.twist_t,
            "v_mps[0]",
            "'v_mps[0]': v_mps is double and has no elements\n  write v_mps",
        ),
        (graphnav_lcm.twist_t, "v_mps.x", "'v_mps.x': v_mps is double, which has no fields\n  write v_mps"),
        (
            graphnav_lcm.flow_t,
            "uv_px[0][0][2]",
            "'uv_px[0][0][2]': uv_px is float[rows][cols][2]\n  its elements on this axis are 0 to 1",
        ),
        (
            graphnav_lcm.status_t,
            "stages.name",
            "'stages.name': stages is an array of graphnav_lcm.stage_status_t\n  name one element: stages[0]",
        ),
        (
            graphnav_lcm.status_t,
            "stages[0].nam",
            "graphnav_lcm.stage_status_t has no field 'nam'\n  did you mean 'name'?",
        ),
    ],
)
def test_what_a_type_does_not_have_is_said(lcm_class: type, path: str, said: str) -> None:
    values = codec_of(lcm_class).decode(codec_of(lcm_class).encode(empty(lcm_class)))
    with pytest.raises(UserError) as caught:
        Selection([parse_field(path)]).of(lcm_class, values)
    assert str(caught.value) == f"--field: {said}"


def empty(lcm_class: Any) -> dict[str, Any]:
    """Return the fields of a message of a type as lcm-gen makes it."""
    made = lcm_class()
    return {name: getattr(made, name) for name in lcm_class.__slots__}


def test_an_element_that_is_not_there_is_nothing() -> None:
    values = {"names": ("a", "b"), "x": np.zeros(2)}
    assert parse_field("names[1]").pick(values) == "b"
    assert parse_field("names[-1:]").pick(values) == ("b",)
    assert parse_field("names[2]").pick(values) is MISSING
    assert parse_field("x[-3]").pick(values) is MISSING


def test_columns_are_known_from_type_and_path() -> None:
    def columns(path: str, lcm_class: type = graphnav_lcm.flow_t) -> list[str]:
        return [column.text for column in columns_of(parse_field(path), lcm_class)]

    assert columns("interval_us") == ["interval_us"]
    assert columns("uv_px[3][-1]") == ["uv_px[3][-1][0]", "uv_px[3][-1][1]"]
    assert columns("valid[0][2:5]") == ["valid[0][2]", "valid[0][3]", "valid[0][4]"]
    assert columns("stages[1]", graphnav_lcm.status_t)[0] == "stages[1].name"
    for path in ("valid", "valid[0]", "valid[0][:-1]", "valid[0][2:]"):
        with pytest.raises(UserError, match="has no fixed number of elements"):
            columns(path)
    with pytest.raises(UserError, match="needs more than 1000 columns"):
        columns("valid[0:100][0:100]")


def test_columns_of_a_complete_type() -> None:
    columns, left_out = all_columns(graphnav_lcm.flow_t)
    assert [column.text for column in columns] == ["utime", "seq", "interval_us", "step_px", "rows", "cols"]
    assert left_out == ["uv_px", "valid"]
    assert len(all_columns(graphnav_lcm.steering_t)[0]) > 8


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of three commands, three flows, three states and one thing that no type explains."""
    path = tmp_path / "log"
    guard = GuardState(**{**_guard(), "causes": ('say "stop"\x1b[31m',)})
    with LogWriter(path) as writer:
        for k in range(3):
            utime = 500_000 * k
            flow = Flow(np.full((2, 3, 2), k + 0.5, np.float32), np.ones((2, 3), np.uint8), 100_000)
            state = State(1.0, k, 0.0, 0.1, 0.0, 0.5, contact=False, at_goal=k == 2, moving=np.zeros((k, 3)))
            writer.write("twist", utime, encode(Twist(0.25 * k, float("nan")), utime, k))
            writer.write("flow", utime, encode(flow, utime, k))
            writer.write("state", utime, encode(state, utime, k))
            writer.write("guard", utime, encode(guard, utime, k))
            writer.write("other", utime, b"unknown")
            writer.write("mixed", utime, encode(flow, utime, k) if k == 1 else encode(Twist(0.5, 0.5), utime, k))
    return path


def _guard() -> dict[str, Any]:
    return {
        "may_move": False,
        "may_advance": False,
        "overridden": False,
        "stopped": True,
        "causes": ("stopped",),
        "ports": ("stop",),
        "values": np.zeros(1),
        "limits": np.zeros(1),
    }


def echoed(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[str, str]:
    assert main(["echo", *map(str, words)]) == 0
    said = capsys.readouterr()
    return said.out, said.err


def test_fields_are_echoed_alone(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, _ = echoed(capsys, "flow", log, "-n", "1", "--field", "uv_px[0][1]", "--field", "valid", "--field", "rows")
    assert out == (
        "flow  graphnav_lcm.flow_t, 98 B\n"
        "    uv_px[0][1]  [0.5, 0.5]\n    valid        uint8 (2, 3)  100.0 % valid\n    rows         2\n"
    )


def test_json_lines_hold_what_was_asked_for(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("flow", log, "--field", "uv_px[1][:2]", "--field", "seq")
    lines = [json.loads(line) for line in echoed(capsys, *words, "--jsonl")[0].splitlines()]
    assert [line["at_s"] for line in lines] == [0, 0.5, 1]
    assert [line["fields"]["seq"] for line in lines] == [0, 1, 2]
    assert lines[1]["fields"]["uv_px[1][:2]"]["shape"] == [2, 2]
    lines = [json.loads(line) for line in echoed(capsys, *words, "--jsonl", "--full")[0].splitlines()]
    assert lines[1]["fields"]["uv_px[1][:2]"] == [[1.5, 1.5], [1.5, 1.5]]


def test_complete_arrays_come_back(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for line in echoed(capsys, "state", log, "--jsonl", "--full")[0].splitlines():
        fields = json.loads(line)["fields"]
        assert fields["moving"] == [[0.0] * 3] * fields["seq"]
    (first, *_) = echoed(capsys, "twist", log, "--json", "--full")[0].splitlines()
    assert json.loads(first)["fields"]["omega_radps"] is None


def rows_of(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text)))


def test_a_table_has_a_column_a_number(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, err = echoed(capsys, "twist", log, "--csv")
    assert err == ""
    assert rows_of(out) == [
        ["at_s", "utime", "seq", "v_mps", "omega_radps"],
        *([f"{0.5 * k:.6f}", str(500_000 * k), str(k), str(0.25 * k), "nan"] for k in range(3)),
    ]
    out, err = echoed(capsys, "flow", log, "--csv", "-n", "2")
    assert err == "omitted: uv_px, valid; select elements of arrays with --field\n"
    assert rows_of(out)[0] == ["at_s", "utime", "seq", "interval_us", "step_px", "rows", "cols"]
    assert len(rows_of(out)) == 3


def test_an_element_that_a_message_lacks_is_an_empty_cell(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, _ = echoed(capsys, "state", log, "--csv", "--field", "moving[1][0]", "--field", "at_goal")
    assert [row[1:] for row in rows_of(out)] == [
        ["moving[1][0]", "at_goal"],
        ["", "False"],
        ["", "False"],
        ["0.0", "True"],
    ]


def test_strings_are_shown_without_what_a_terminal_obeys(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["--csv"], [], ["--jsonl"], ["--full"]):
        out, _ = echoed(capsys, "guard", log, "--field", "causes[0]", *words)
        assert "\x1b" not in out
        assert out.count("stop") == 3
    assert rows_of(echoed(capsys, "guard", log, "--csv", "--field", "causes[0]")[0])[1][1] == 'say "stop"\\x1b[31m'


def test_other_types_have_no_row_and_are_counted(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, err = echoed(capsys, "mixed", log, "--csv")
    assert len(rows_of(out)) == 3
    assert err == "1 messages skipped: undecodable, or not graphnav_lcm.twist_t\n"
    out, _ = echoed(capsys, "mixed", log, "--field", "v_mps")
    assert out.count("another type: it has no such fields") == 1
    lines = [json.loads(line) for line in echoed(capsys, "mixed", log, "--field", "v_mps", "--jsonl")[0].splitlines()]
    assert [line["fields"] for line in lines] == [{"v_mps": 0.5}, None, {"v_mps": 0.5}]


def test_a_message_of_an_unknown_type_is_shown_with_what_decodes_it(
    log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, _ = echoed(capsys, "other", log, "-n", "1")
    assert out == "other  unknown type, 7 B\n    its type is not known: --types PACKAGE_OR_DIR, or --plugin FILE\n"


def test_a_table_of_what_cannot_be_decoded_fails(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["echo", "other", str(log), "--csv"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == (
        "none of 3 messages could be decoded\n"
        "  name its package or its .lcm files: --types PACKAGE_OR_DIR, or its plugin: --plugin FILE\n"
    )


def test_a_table_of_truncated_messages_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "log") as writer:
        for k in range(3):
            writer.write("cut", k, encode(Twist(0.5, 0.5), k, k)[:-1])
    assert main(["echo", "cut", str(tmp_path / "log"), "--csv"]) == 1
    assert capsys.readouterr().err == (
        "none of 3 messages is a complete graphnav_lcm.twist_t\n"
        "  check the program that sends them: they are truncated, or of another type\n"
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["twist", "--field", "v"], "--field: graphnav_lcm.twist_t has no field 'v'\n  its fields are"),
        (
            ["flow", "--csv", "--field", "valid"],
            (
                "--field: 'valid' has no fixed number of elements, so no columns\n"
                "  name elements, valid[0][0] or valid[0][0:8], or use --jsonl --full\n"
            ),
        ),
        (
            ["twist", "--csv", "--full"],
            "--csv: a table has no complete arrays\n  use --jsonl --full, or name elements\n",
        ),
    ],
)
def test_what_cannot_be_echoed_is_a_users_error(
    log: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert main(["echo", *words, str(log)]) == 2
    assert capsys.readouterr().err.startswith(said)
