"""``graphnav types``: every type can be looked up, its definition makes it again, and Java loads it."""

from __future__ import annotations

import importlib
import json
import os
import re
import shutil
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from types import ModuleType

import graphnav_lcm
import pytest

from graphnav.core.cli import main
from graphnav.core.codec import SHIPPED, comments_of, constants_of, find_type, fingerprint, lcm_name
from graphnav.core.errors import UserError
from graphnav.core.typeinfo import definition_files
from graphnav.develop.java import write_java

from .conftest import TOOLS

JAVA = shutil.which("java"), shutil.which("javac"), shutil.which("jar")
PROBE = """\
public class Probe {
    public static void main(String[] names) throws Exception {
        for (String name : names)
            System.out.printf("%s %016x%n", name, Class.forName(name).getField("LCM_FINGERPRINT").getLong(null));
    }
}
"""


@pytest.mark.parametrize("name", ["Flow", "flow_t", "graphnav_lcm.flow_t"])
def test_a_type_has_three_names(name: str) -> None:
    assert find_type(name) is graphnav_lcm.flow_t


def test_types_that_no_message_wraps_are_found() -> None:
    assert find_type("input_status_t") is graphnav_lcm.input_status_t


def test_other_types_are_found_by_name_and_ours_come_first(codec_types: ModuleType) -> None:
    more = {"other.every_t": codec_types.every_t, "other.image_t": codec_types.every_t}
    assert find_type("other.every_t", more) is codec_types.every_t
    assert find_type("every_t", more) is codec_types.every_t
    assert find_type("other.image_t", more) is codec_types.every_t
    assert find_type("image_t", more) is graphnav_lcm.image_t
    assert find_type("codec_types.every_t") is codec_types.every_t
    with pytest.raises(UserError, match=r"there is no LCM type 'other\.every'\n  did you mean 'other\.every_t'\?"):
        find_type("other.every", more)


def test_comments_are_those_of_the_definition() -> None:
    comments = comments_of(graphnav_lcm.flow_t)
    assert comments["uv_px"].startswith("Displacement since the last frame of the point that is now here: right, down;")
    assert "utime" not in comments
    assert comments_of(dict) == {}


@pytest.mark.parametrize("lcm_class", SHIPPED, ids=lcm_name)
def test_every_comment_above_a_field_is_found(lcm_class: type) -> None:
    definition = definition_files([lcm_class])[f"{lcm_name(lcm_class)}.lcm"]
    comments = comments_of(lcm_class)
    for above, name in re.findall(r"// (.*)\n\s+\w+ (\w+)", definition):
        assert comments[name].endswith(above)


def test_constants_are_shown(codec_types: ModuleType) -> None:
    assert constants_of(graphnav_lcm.flow_t) == {}
    found = constants_of(codec_types.every_t)
    assert all(isinstance(value, int | float) for value in found.values())


def test_every_definition_is_package_data() -> None:
    for lcm_class in SHIPPED:
        text = files("graphnav_lcm").joinpath(f"{lcm_class.__name__}.lcm").read_text()
        assert text == definition_files([lcm_class])[f"{lcm_name(lcm_class)}.lcm"]


def test_definitions_make_the_same_types_again(codec_types: ModuleType, tmp_path: Path) -> None:
    lcm_classes = [*SHIPPED, codec_types.every_t, codec_types.holder_t]
    again = re.sub(r"\b(codec_types|graphnav_lcm)\b", r"defined_\1", "\n".join(definition_files(lcm_classes).values()))
    (tmp_path / "all.lcm").write_text(again)
    subprocess.run([str(TOOLS / "lcm-gen"), "-p", "--ppath", str(tmp_path), str(tmp_path / "all.lcm")], check=True)
    sys.path.insert(0, str(tmp_path))
    try:
        importlib.import_module("defined_codec_types.deep")
        for lcm_class in lcm_classes:
            package, _, name = lcm_name(lcm_class).rpartition(".")
            made = getattr(importlib.import_module(f"defined_{package}"), name)
            assert fingerprint(made) == fingerprint(lcm_class)
    finally:
        sys.path.remove(str(tmp_path))


def test_all_types_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["types", "--json"]) == 0
    listed = {one["type"]: one for one in json.loads(capsys.readouterr().out)}
    assert {lcm_name(lcm_class) for lcm_class in SHIPPED} <= set(listed)
    assert listed["graphnav_lcm.twist_t"]["message"] == "Twist"
    assert listed["graphnav_lcm.edge_status_t"]["message"] is None
    assert listed["bot_core.image_t"]["nested"] == ["bot_core.image_metadata_t"]
    assert "bot_core.image_metadata_t" in listed
    assert main(["types"]) == 0
    assert "graphnav_lcm.twist_t" in capsys.readouterr().out


def test_one_type_is_told(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["types", "Twist", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fingerprint"] == fingerprint(graphnav_lcm.twist_t).hex()
    assert told["fields"][0] | {"doc": ""} == {
        "name": "utime",
        "type": "int64_t",
        "dims": [],
        "unit": "microseconds",
        "doc": "",
    }
    assert told["fields"][3] == {
        "name": "omega_radps",
        "type": "double",
        "dims": [],
        "unit": "radians per second",
        "doc": "Turning rate, counterclockwise.",
    }
    monkeypatch.setenv("COLUMNS", "160")
    assert main(["types", "flow_t"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("Flow, graphnav_lcm.flow_t, fingerprint ")
    assert re.search(r"uv_px +float\[rows\]\[cols\]\[2\] +pixels +Displacement since the last frame", said)
    assert "float32 (rows, cols, 2), right and down" in said
    assert main(["types", "Status"]) == 0
    assert "'graphnav types graphnav_lcm.stage_status_t' describes it." in capsys.readouterr().out


def test_the_definition_is_printed_as_it_was_written(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["types", "Stop", "--lcm"]) == 0
    written = Path(__file__).resolve().parents[2] / "lcmtypes" / "stop_t.lcm"
    assert capsys.readouterr().out == written.read_text()


@pytest.mark.parametrize("name", ["bot_core.image_t", "bot_core.image_metadata_t", "image_metadata_t"])
def test_types_of_adapters_are_told(capsys: pytest.CaptureFixture[str], name: str) -> None:
    assert main(["types", name, "--lcm"]) == 0
    assert f"struct {name.rpartition('.')[2]}\n" in capsys.readouterr().out


def test_a_type_that_is_not_there_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["types", "Flw"]) == 2
    assert capsys.readouterr().err == "there is no LCM type 'Flw'\n  did you mean 'Flow'?\n"


@pytest.mark.skipif(None in JAVA, reason="there is no Java here")
def test_java_loads_the_jar(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["types", "--java", str(tmp_path / "out")]) == 0
    jar = tmp_path / "out" / "types.jar"
    assert capsys.readouterr().out.endswith(f"then CLASSPATH={jar} lcm-spy shows these types\n")
    (tmp_path / "Probe.java").write_text(PROBE)
    (lcm_jar,) = (path for path in Path(TOOLS).resolve().parent.rglob("lcm.jar"))
    names = [lcm_name(lcm_class) for lcm_class in SHIPPED]
    command = ["java", "-cp", f"{jar}{os.pathsep}{lcm_jar}", str(tmp_path / "Probe.java"), *names]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    told = dict(line.split() for line in done.stdout.splitlines())
    assert told == {lcm_name(lcm_class): fingerprint(lcm_class).hex() for lcm_class in SHIPPED}


def test_without_a_compiler_there_are_sources_and_what_to_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", "")
    assert main(["types", "Status", "--java", str(tmp_path)]) == 0
    made = write_java([graphnav_lcm.status_t], tmp_path)
    assert not made.is_built
    assert {source.stem for source in made.sources} == {
        "status_t",
        "stage_status_t",
        "input_status_t",
        "output_status_t",
        "edge_status_t",
        "process_status_t",
    }
    assert all(source.is_file() for source in made.sources)
    said = capsys.readouterr().out.splitlines()
    assert said[1] == "javac is not installed: install a JDK, or run on a machine that has one"
    assert said[2].startswith("  javac -cp ")
    assert said[3].startswith(f"  jar cf {tmp_path / 'types.jar'} -C ")


@pytest.mark.skipif(None in JAVA, reason="there is no Java here")
def test_the_commands_that_are_said_build_the_jar(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as without:
        without.setenv("PATH", "")
        made = write_java([graphnav_lcm.twist_t], tmp_path)
    for command in made.commands:
        subprocess.run(["/bin/sh", "-c", command], check=True)
    assert made.jar.is_file()


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    assert main(["types", "Twist", "--java", str(tmp_path / "file")]) == 1
    assert capsys.readouterr().err == f"stopped: File exists: {tmp_path / 'file'}\n"
