"""``--types``: messages of types that are not installed are decoded by their definitions."""

from __future__ import annotations

import importlib
import json
import os
import re
import subprocess
import sys
import uuid
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphnav.core.cli import main
from graphnav.core.codec import codec_of, fields_of, fingerprint, lcm_name, type_named, type_of
from graphnav.core.errors import UserError
from graphnav.core.record import LogWriter
from graphnav.core.typeinfo import definition_files, load_types

from .conftest import TOOLS
from .recording import GRAPHNAV, RecordProcess, events_of, wait_until


@pytest.fixture
def mark() -> str:
    """Return a word that no other test uses in a name: what is made known stays known in this process."""
    return f"m{uuid.uuid4().hex[:12]}"


@pytest.fixture
def types(tmp_path: Path, mark: str) -> Path:
    """Return a folder of definitions in two packages that use each other's types."""
    folder = tmp_path / "types"
    (folder / "deep").mkdir(parents=True)
    (folder / "pose_t.lcm").write_text(
        f"package {mark}_base;\n"
        '// A pose, it is "commented".\n'
        "struct pose_t\n{\n"
        f"    int64_t {mark};\n    double position[3];\n    {mark}_parts.wheel_t wheels[2];\n"
        "    int32_t n;\n    string names[n];\n    /* it stays */ const int8_t LIMIT = 3;\n}\n"
    )
    (folder / "deep" / "wheel_t.lcm").write_text(
        f"package {mark}_parts;\nstruct wheel_t\n{{\n    float speed;\n    int16_t ticks[2][3];\n}}\n"
    )
    return folder


def pose_of(mark: str) -> dict[str, Any]:
    """Return the fields of a pose."""
    wheels = tuple({"speed": speed, "ticks": [[1, 2, 3], [4, 5, 6]]} for speed in (0.5, -0.5))
    return {mark: 7, "position": [1.0, 2.0, 3.0], "wheels": wheels, "n": 2, "names": ("a", "b")}


def generated(folder: Path, types: Path) -> None:
    """Let lcm-gen write the Python of all definitions in ``types``."""
    subprocess.run([TOOLS / "lcm-gen", "-p", "--ppath", folder, *sorted(types.rglob("*.lcm"))], check=True)


def log_of(path: Path, data: bytes) -> Path:
    """Return a log that holds one message, as another program's logger writes it."""
    with LogWriter(path) as writer:
        writer.write("POSE", 1_000_000, data)
    return path


def test_a_foreign_message_is_decoded_by_a_folder_of_definitions(
    tmp_path: Path, types: Path, mark: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    generated(tmp_path / "python", types)
    monkeypatch.syspath_prepend(str(tmp_path / "python"))
    theirs = importlib.import_module(f"{mark}_base").pose_t
    data = codec_of(theirs).encode(pose_of(mark))
    log = log_of(tmp_path / "log", data)

    assert main(["spy", str(log)]) == 0
    assert "POSE  unknown type, " in capsys.readouterr().out
    assert main(["echo", "POSE", str(log), "--types", str(types)]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"POSE  {mark}_base.pose_t, ")
    assert re.search(r"^    position +\[1, 2, 3\]$", said, re.MULTILINE)

    ours = type_of(data)
    assert ours is not None
    assert ours is not theirs
    assert lcm_name(ours) == codec_of(ours).name == f"{mark}_base.pose_t"
    assert fingerprint(ours) == fingerprint(theirs)
    assert sys.modules[f"{mark}_base"].pose_t is theirs


def test_files_may_be_named_one_by_one(types: Path, mark: str) -> None:
    names = [str(types / "pose_t.lcm"), str(types / "deep" / "wheel_t.lcm"), str(types)]
    loaded = load_types(names)
    assert set(loaded) == {f"{mark}_base.pose_t", f"{mark}_parts.wheel_t"}
    assert type_named(f"{mark}_base.pose_t") is loaded[f"{mark}_base.pose_t"]


def test_decoding_inverts_encoding(types: Path, mark: str) -> None:
    codec = codec_of(load_types([str(types)])[f"{mark}_base.pose_t"])
    values = codec.decode(codec.encode(pose_of(mark)))
    assert values["wheels"][1]["speed"] == -0.5
    assert values["wheels"][0]["ticks"].tolist() == [[1, 2, 3], [4, 5, 6]]
    assert values["names"] == ("a", "b")


def test_a_package_that_lcm_gen_wrote(tmp_path: Path, types: Path, mark: str, monkeypatch: pytest.MonkeyPatch) -> None:
    generated(tmp_path / "python", types)
    (tmp_path / "python" / f"{mark}_base" / "trap.py").write_text("raise SystemExit('not to be imported')\n")
    monkeypatch.syspath_prepend(str(tmp_path / "python"))
    assert set(load_types([f"{mark}_base"])) == {f"{mark}_base.pose_t"}
    found = type_named(f"{mark}_base.pose_t")
    assert found is not None
    assert type_of(fingerprint(found)) is found


def test_what_ships_need_not_be_defined_again(tmp_path: Path, mark: str) -> None:
    text = (
        f"package {mark};\nstruct order_t\n{{\n    graphnav_lcm.status_t {mark};\n    graphnav_lcm.twist_t twist;\n}}\n"
    )
    (tmp_path / "order_t.lcm").write_text(text)
    loaded = load_types([str(tmp_path)])
    assert set(loaded) == {f"{mark}.order_t"}
    fields = fields_of(loaded[f"{mark}.order_t"])
    assert [field.primitive for field in fields] == ["graphnav_lcm.status_t", "graphnav_lcm.twist_t"]


def test_a_type_outside_of_packages(tmp_path: Path, mark: str) -> None:
    (tmp_path / "lone.lcm").write_text(f"struct {mark}_t\n{{\n    int8_t {mark};\n}}\n")
    (lcm_class,) = load_types([str(tmp_path / "lone.lcm")]).values()
    assert lcm_name(lcm_class) == f"{mark}_t"
    assert type_named(f"{mark}_t") is lcm_class


def test_nothing_that_comments_say_is_run(tmp_path: Path, mark: str) -> None:
    ran = tmp_path / "ran"
    trap = f'""" + str(open({str(ran)!r}, "w")) + """'
    text = f"/* {trap} */\npackage {mark};\n/* {trap} */\nstruct a_t\n{{\n    // {trap}\n    int8_t {mark};\n}}\n"
    (tmp_path / "a_t.lcm").write_text(text)
    load_types([str(tmp_path)])
    assert not ran.exists()


def test_nothing_is_left_behind(types: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    path = list(sys.path)
    load_types([str(types)])
    assert list(temporary.iterdir()) == []
    assert sys.path == path


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("package {mark};\nstruct a_t\n{{\n  int32_t foo bar;\n}}\n", "{file}:4:15: lcm-gen: expected token ;"),
        (
            "package {mark};\n/* one\n   two */ struct a_t\n{{\n  int8_t a;\n  int8_t a;\n}}\n",
            "{file}:6: lcm-gen: Duplicate member name 'a'.",
        ),
        ("hello\n", "{file}:1:1: lcm-gen: Missing struct token."),
        (
            "package {mark};\nstruct a_t\n{{\n  other.b_t first;\n  c_t second;\n}}\n",
            (
                "{file}:4:3: {mark}.a_t.first has the type other.b_t, which is not defined\n"
                "  also give the folder that defines it: --types DIR\n"
                "{file}:5:3: {mark}.a_t.second has the type {mark}.c_t, which is not defined\n"
                "  also give the folder that defines it: --types DIR"
            ),
        ),
        (
            "package {mark};\nstruct a_t\n{{\n  int8_t class;\n}}\n",
            (
                "Python cannot hold the type {mark}.a_t: one of its names is a Python keyword\n"
                "  rename the field, the type or the package"
            ),
        ),
        (
            "package {mark};\nstruct a_t\n{{\n  int8_t encode;\n}}\n",
            (
                "--types: Python cannot hold the type {mark}.a_t: ValueError: 'encode' in __slots__ conflicts with "
                "class variable\n  rename the field, the type or the package"
            ),
        ),
        ("", "--types: no types are defined in {file}"),
        ("/* never ends", "--types: lcm-gen: {file} : EOF reached while parsing comment"),
        (
            "package {mark};\nstruct a_t\n{{\n  int8_t a;\n}}\nstruct a_t\n{{\n  int8_t b;\n}}\n",
            (
                "--types: lcm-gen: ERROR: duplicate type {mark}.a_t declared in {file} "
                "{mark}.a_t was previously declared in {file}"
            ),
        ),
    ],
)
def test_what_lcm_gen_or_python_refuses_is_a_users_error(
    tmp_path: Path, mark: str, capsys: pytest.CaptureFixture[str], text: str, said: str
) -> None:
    file = tmp_path / "a_t.lcm"
    file.write_text(text.format(mark=mark))
    assert main(["spy", "--once", "--types", str(tmp_path)]) == 2
    wanted = said.format(file=file, mark=mark)
    assert capsys.readouterr().err.removesuffix("2 errors\n") == f"{wanted}\n"


@pytest.mark.parametrize(
    "data", [b"\0\xff\x1b[31m", b"package p;\nstruct \x1b[31m_t\n{\n int8_t a;\n}\n", bytes(range(256))]
)
def test_bytes_of_any_kind_are_a_users_error(tmp_path: Path, capsys: pytest.CaptureFixture[str], data: bytes) -> None:
    (tmp_path / "a.lcm").write_bytes(data)
    assert main(["echo", "x", "--types", str(tmp_path / "a.lcm")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"{tmp_path / 'a.lcm'}:")
    assert said.replace("\n", "").isprintable()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nothing/", "there is no folder, file or installed package 'nothing/'\n  name a folder of .lcm files\n"),
        (
            "no_such_package",
            (
                "there is no folder, file or installed package 'no_such_package'\n"
                "  name a folder of .lcm files, or a package written by lcm-gen -p; set PYTHONPATH to find others\n"
            ),
        ),
        ("json", "the package 'json' holds no LCM types\n  name a package written by lcm-gen -p\n"),
        ("missing.lcm", "there is no folder, file or installed package 'missing.lcm'\n  name a folder of .lcm files\n"),
        ("./", "the folder './' holds no .lcm files\n  name one that does\n"),
        (
            "./made",
            "the folder './made' holds no .lcm files\n  for its Python set PYTHONPATH={here} and write --types made\n",
        ),
        ("log", "'./log' is not a .lcm file\n  name a .lcm file or a folder of them\n"),
        ("a\0b", "there is no folder, file or installed package 'a\\x00b'\n  name a folder of .lcm files\n"),
        ("", "there is no folder, file or installed package ''\n  name a folder of .lcm files\n"),
    ],
)
def test_what_holds_no_types_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "log").touch()
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "__init__.py").touch()
    assert main(["hz", "--types", "./log" if name == "log" else name]) == 2
    assert capsys.readouterr().err == f"--types: {said.format(here=tmp_path)}"


def test_a_package_that_cannot_be_imported_is_said(tmp_path: Path, mark: str, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / f"{mark}.py").write_text("import no_such_module_at_all\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(UserError, match=rf"--types: the package '{mark}' cannot be imported: ModuleNotFoundError: "):
        load_types([mark])


def test_they_can_be_looked_up_and_published(
    types: Path, mark: str, group: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["types", f"{mark}_base.pose_t", "--json", "--types", str(types)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["type"] == f"{mark}_base.pose_t"
    assert told["nested"] == [f"{mark}_parts.wheel_t"]
    assert main(["pub", "WHEEL", f"{mark}_parts.wheel_t", "speed: 2.5", "--types", str(types), "--url", group]) == 0
    assert f"publishing {mark}_parts.wheel_t on 'WHEEL' once" in capsys.readouterr().out


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads every file")
def test_a_file_that_may_not_be_read_is_said(types: Path) -> None:
    (types / "pose_t.lcm").chmod(0)
    with pytest.raises(UserError, match=r"cannot read .*pose_t\.lcm: Permission denied"):
        load_types([str(types)])


def test_the_definition_can_be_printed_and_made_again(types: Path, tmp_path: Path, mark: str) -> None:
    loaded = load_types([str(types)])
    again = tmp_path / "again"
    again.mkdir()
    for name, text in definition_files(loaded.values()).items():
        (again / name).write_text(text)
    once_more = load_types([str(again)])
    assert {name: fingerprint(one) for name, one in once_more.items()} == {
        name: fingerprint(one) for name, one in loaded.items()
    }


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.integers(0, 400), st.integers(0, 6), st.text(max_size=4)), min_size=1, max_size=4))
def test_a_damaged_definition_is_loaded_or_a_users_error(
    tmp_path: Path, mark: str, changes: list[tuple[int, int, str]]
) -> None:
    text = (
        f"package {mark};\nstruct a_t\n{{\n    int64_t {mark};\n    double x[3];\n    b_t other;\n    int32_t n;\n"
        "    string names[n][2]; // said\n}\n/* and */ struct b_t\n{\n    const int8_t TWO = 2;\n    byte data[4];\n}\n"
    )
    for place, length, inserted in changes:
        text = text[: place % len(text)] + inserted + text[place % len(text) + length :]
    file = tmp_path / "a_t.lcm"
    file.write_text(text, encoding="utf-8", errors="replace")
    try:
        loaded = load_types([str(file)])
    except UserError:
        return
    for lcm_class in loaded.values():
        codec_of(lcm_class)


def test_a_recording_with_types_decodes_where_they_are_not_installed(
    group: str, tmp_path: Path, types: Path, mark: str
) -> None:
    generated(tmp_path / "python", types)
    log = tmp_path / "log"
    process = RecordProcess(group, log, "--types", str(types))
    try:
        process.publish_until_heard()
        codec = codec_of(load_types([str(types)])[f"{mark}_base.pose_t"])
        process.bus.publish("POSE", codec.encode(pose_of(mark)))
        wait_until(lambda: any(event.channel == "POSE" for event in events_of(log)))
        assert process.end()[0] == 0
    finally:
        process.close()
    echo = [GRAPHNAV, "echo", "POSE", str(log)]
    said = subprocess.run(echo, check=True, capture_output=True, text=True, timeout=60).stdout
    assert said.startswith(f"POSE  {mark}_base.pose_t, ")
    assert re.search(rf"^    {mark} +7$", said, re.MULTILINE)
