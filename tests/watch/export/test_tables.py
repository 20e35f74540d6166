"""Tables hold every scalar of the log, and nothing is read back as something else."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphnav import Twist
from graphnav.core.cli import main
from graphnav.core.codec import codec_of, encode, type_named
from graphnav.core.messages import About
from graphnav.core.record import LogWriter, Recording
from graphnav.watch.export import export_log
from graphnav.watch.export.scalar_fields import leaves_of

INTS = {
    name: st.integers(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for name, bits in (("i8", 8), ("i16", 16), ("i32", 32), ("i64", 64))
}
TEXTS = st.text(st.characters(codec="utf-8"), max_size=12)
EVERY: dict[str, st.SearchStrategy[Any]] = {
    "utime": st.integers(-(2**63), 2**63 - 1),
    "seq": st.integers(0, 2**62),
    **INTS,
    "b": st.integers(0, 255),
    "f32": st.floats(width=32),
    "f64": st.floats(),
    "flag": st.booleans(),
    "text": TEXTS,
    "texts": st.tuples(TEXTS, TEXTS),
    "f64s": st.lists(st.floats(), min_size=6, max_size=6).map(lambda values: np.reshape(values, (3, 2))),
}


def every(values: dict[str, Any]) -> dict[str, Any]:
    """Return fields of ``every_t`` whose other arrays are empty or zero."""
    inner = {"id": 1, "fixed": np.zeros(2), "n": 0, "variable": np.zeros(0, np.float32), "name": 'a,"b"\n', "on": True}
    return values | {
        "rows": 0,
        "cols": 0,
        "i8s": np.zeros(3, np.int8),
        "i16s": np.zeros((2, 2), np.int16),
        "i32s": np.zeros(3, np.int32),
        "i64s": np.full((1, 2, 2), 2**60 + 1),
        "bytes": np.zeros(4, np.uint8),
        "bytes2": np.zeros((2, 3), np.uint8),
        "f32s": np.array([0.1, np.nan], np.float32),
        "flags": np.array([True, False, True, False, True]),
        "texts2": (("a", "b"), ("nan", "")),
        "i8v": np.zeros(0, np.int8),
        "i16v": np.zeros((0, 2), np.int16),
        "i32v": np.zeros((0, 0), np.int32),
        "i64v": np.zeros((2, 0), np.int64),
        "bv": np.zeros(0, np.uint8),
        "bv2": np.zeros((0, 0), np.uint8),
        "f32v": np.zeros((0, 0, 2), np.float32),
        "f64v": np.zeros(0),
        "flagv": np.zeros((0, 0), np.bool_),
        "textv": (),
        "textv2": (),
        "one": inner,
        "fixed": (inner, inner | {"id": 2**31 - 1}),
        "variable": (),
        "grid": ((), ()),
    }


def same(one: Any, other: Any) -> bool:
    """Whether two scalars are the same, in type and in value: NaN is NaN, and zero has a sign."""
    if isinstance(one, float) and isinstance(other, float):
        return (math.isnan(one) and math.isnan(other)) or (
            one == other and math.copysign(1, one) == math.copysign(1, other)
        )
    return type(one) is type(other) and bool(one == other)


def read_csv(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a table, all cells as strings."""
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    return [dict(zip(lines[0], line, strict=True)) for line in lines[1:]]


def parsed(text: str, like: Any) -> Any:
    """Return a cell as the type of ``like``."""
    if isinstance(like, bool):
        return {"True": True, "False": False}[text]
    return type(like)(text)


def expected(recording: Recording, channel: str) -> list[dict[str, Any]]:
    """Return what a table of a channel has to hold."""
    lcm_class = recording.channels[channel]
    assert lcm_class is not None
    return [
        {"log_utime": recording.event(channel, index).utime}
        | {leaf.name: leaf.of(recording.fields(channel, index)) for leaf in leaves_of(lcm_class)}
        for index in range(recording.count(channel))
    ]


@settings(derandomize=True, deadline=None, max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=st.lists(st.fixed_dictionaries(EVERY), min_size=1, max_size=4))
def test_scalars_come_back_as_they_were(
    codec_types: ModuleType, tmp_path_factory: pytest.TempPathFactory, rows: list[dict[str, Any]]
) -> None:
    folder = tmp_path_factory.mktemp("tables")
    with LogWriter(folder / "log") as log:
        for place, row in enumerate(rows):
            log.write("ALL", 7 * place, codec_of(codec_types.every_t).encode(every(row)))
    with Recording(folder / "log") as recording:
        wanted = expected(recording, "ALL")
        for kind in ("csv", "parquet"):
            assert export_log(recording, kind, folder / kind).losses == []
        from_csv = read_csv(folder / "csv" / "ALL.csv")
        assert [list(row) for row in from_csv] == [list(row) for row in wanted]
        for row, want in zip(from_csv, wanted, strict=True):
            assert all(same(parsed(row[name], value), value) for name, value in want.items()), (row, want)
        from_parquet = pq.read_table(folder / "parquet" / "ALL.parquet").to_pylist()
        for row, want in zip(from_parquet, wanted, strict=True):
            assert row.keys() == want.keys()
            assert all(same(row[name], value) for name, value in want.items()), (row, want)


def test_columns_have_the_types_of_the_fields(codec_types: ModuleType, tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        row = {"utime": 1, "seq": 2, "i8": 1, "i16": 1, "i32": 1, "i64": 2**62 + 1, "b": 255, "f32": 0.5, "f64": 0.5}
        values = every(row | {"flag": True, "text": "é", "texts": ("", "b"), "f64s": np.zeros((3, 2))})
        log.write("ALL", 7, codec_of(codec_types.every_t).encode(values))
    assert (
        main(["export", str(tmp_path / "log"), "--to", "parquet", "--channel", "ALL", "-o", str(tmp_path / "t")]) == 0
    )
    schema = pq.read_schema(tmp_path / "t")
    kinds = {name: str(schema.field(name).type) for name in ("log_utime", "i8", "i16", "i32", "i64", "b", "f32", "f64")}
    assert list(kinds.values()) == ["int64", "int8", "int16", "int32", "int64", "uint8", "float", "double"]
    assert [str(schema.field(name).type) for name in ("flag", "text", "flags[4]", "one.name")] == ["bool", "string"] * 2
    assert "f64s[2][1]" in schema.names
    assert "i64s[0][1][1]" in schema.names
    assert "fixed[1].id" in schema.names
    assert not any(name.startswith(("i8v", "variable")) for name in schema.names)


def test_strings_are_in_quotes_and_numbers_are_not(codec_types: ModuleType, tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        row = {"utime": 1, "seq": 2, "i8": 1, "i16": 1, "i32": 1, "i64": 1, "b": 2, "f32": math.nan, "f64": math.inf}
        values = every(row | {"flag": False, "text": "nan", "texts": ("1", ""), "f64s": np.zeros((3, 2))})
        log.write("ALL", 7, codec_of(codec_types.every_t).encode(values))
    assert (
        main(["export", str(tmp_path / "log"), "--to", "csv", "--channel", "ALL", "-o", str(tmp_path / "t.csv")]) == 0
    )
    header, line = (tmp_path / "t.csv").read_text().split("\n", 1)
    assert header.startswith('"log_utime","utime","seq","i8","i16","i32","i64","b","f32","f64","flag","text"')
    assert line.startswith('7,1,2,1,1,1,1,2,nan,inf,False,"nan"')


@pytest.mark.parametrize(("kind", "suffix"), [("csv", ".csv"), ("parquet", ".parquet")])
def test_a_drive_gives_a_file_for_each_channel(drive: Path, tmp_path: Path, kind: str, suffix: str) -> None:
    assert main(["export", str(drive), "--to", kind, "-o", str(tmp_path / "tables")]) == 0
    with Recording(drive / "run.lcmlog") as recording:
        wanted = {name: expected(recording, name) for name in recording.channels if name != About.CHANNEL}
    assert {file.name for file in (tmp_path / "tables").iterdir()} == {f"{name}{suffix}" for name in wanted}
    for name, rows in wanted.items():
        path = tmp_path / "tables" / f"{name}{suffix}"
        found: list[dict[str, Any]] = read_csv(path) if kind == "csv" else pq.read_table(path).to_pylist()
        assert len(found) == len(rows)
        for row, want in zip(found, rows, strict=True):
            cells = {n: parsed(row[n], value) if kind == "csv" else row[n] for n, value in want.items()}
            assert all(same(cells[n], value) for n, value in want.items())


def test_a_span_and_a_pattern_choose(drive: Path, tmp_path: Path) -> None:
    words = ["--channel", "control.*", "--channel", "steer.steering", "--from", "0.5s", "--until", "1"]
    assert main(["export", str(drive), "--to", "csv", "-o", str(tmp_path / "tables"), *words]) == 0
    assert {p.name for p in (tmp_path / "tables").iterdir()} == {"control.twist.csv", "steer.steering.csv"}
    rows = read_csv(tmp_path / "tables" / "control.twist.csv")
    assert [int(row["log_utime"]) for row in rows] == [100_000 * k for k in range(5, 11)]


def test_names_of_channels_become_names_of_files(tmp_path: Path) -> None:
    names = ["a/b", "..", "x\x1b[31m", "CON", "é", "n" * 500, "n" * 501]
    with LogWriter(tmp_path / "log") as log:
        for name in names:
            log.write(name, 0, encode(Twist(v_mps=1.0, omega_radps=2.0), 0, 0))
    assert main(["export", str(tmp_path / "log"), "--to", "csv", "-o", str(tmp_path / "tables")]) == 0
    files = sorted(path.name for path in (tmp_path / "tables").iterdir())
    assert len(files) == len(names)
    assert all(name.isascii() and name.isprintable() and "/" not in name for name in files)
    assert "a%2Fb.csv" in files
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log", "tables"]


def test_types_of_other_programs_are_named_by_their_definitions(tmp_path: Path) -> None:
    (tmp_path / "types").mkdir()
    (tmp_path / "types" / "wheel_t.lcm").write_text(
        "package exported_rover;\nstruct wheel_t { int64_t n; double w_radps[2]; }\n"
    )
    assert main(["types", "exported_rover.wheel_t", "--types", str(tmp_path / "types")]) == 0
    lcm_class = type_named("exported_rover.wheel_t")
    assert lcm_class is not None
    with LogWriter(tmp_path / "log") as log:
        log.write("WHEEL", 5, codec_of(lcm_class).encode({"n": 3, "w_radps": np.array([0.5, -1.0])}))
    words = ["--types", str(tmp_path / "types"), "--channel", "WHEEL"]
    assert main(["export", str(tmp_path / "log"), "--to", "csv", "-o", str(tmp_path / "w.csv"), *words]) == 0
    assert (tmp_path / "w.csv").read_text() == '"log_utime","n","w_radps[0]","w_radps[1]"\n5,3,0.5,-1.0\n'
