"""``graphnav new-stage`` writes a stage that works and a test that passes, and overwrites nothing."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.cli import main

KINDS = ["io", "world", "flow", "planar", "plane", "steer", "control", "score", "view", "mine"]
FAMILIES = sorted({*KINDS, *Catalog().families()})
RUN, TEST = "Try it: ", "run it with: "


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_in_every_family_the_written_test_passes(tmp_path: Path) -> None:
    for family in FAMILIES:
        assert main(["new-stage", family, f"my_{family}"]) == 0
        catalog = Catalog()
        catalog.add_file(Path(f"my_{family}.py"))
        cls = "".join(part.capitalize() for part in f"my_{family}".split("_"))
        assert catalog.stage(f"{family}.my_{family}").__name__ == cls
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert f"{2 * len(FAMILIES)} passed" in done.stdout


def test_what_is_written_is_well_typed_and_formatted(tmp_path: Path) -> None:
    for family in FAMILIES:
        main(["new-stage", family, f"my_{family}"])
    for tool in (["ruff", "format", "--check", "--line-length", "120"], ["ruff", "check"]):
        done = subprocess.run(
            [sys.executable, "-m", *tool, "."], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("family", FAMILIES)
def test_the_printed_run_runs(family: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["new-stage", family, "my_stage", "-o", "a folder"])
    program, *words = shlex.split(printed(RUN, capsys))
    assert program == "graphnav"
    assert main([*words, "--until", "0.5", "--no-tap", "--no-pictures", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    steps = {steps_of["use"]: steps_of["steps"] for steps_of in summary["stages"].values()}
    assert steps[f"{family}.my_stage"] > 0


def test_the_printed_test_runs(capsys: pytest.CaptureFixture[str]) -> None:
    main(["new-stage", "plane", "my_stage", "-o", "a folder"])
    program, *words = shlex.split(printed(TEST, capsys))
    assert program == "python"
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("name", ["robot", "run", "new_robot", "n" * 60])
def test_a_stage_is_added_by_a_name_that_is_free(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["new-stage", "mine", name])
    assert main([*shlex.split(printed(RUN, capsys))[1:], "--until", "0.1", "--no-tap", "--no-pictures"]) == 0


def test_the_printed_graph_names_the_plugin(capsys: pytest.CaptureFixture[str]) -> None:
    main(["new-stage", "world", "my_world"])
    assert "plugins: [my_world.py], and a stage with use: world.my_world" in capsys.readouterr().out
    Path("graph.yaml").write_text("plugins: [my_world.py]\nstages: {camera: {use: world.my_world}}\n")
    assert main(["check", "graph", "--trust"]) == 0


def printed(before: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one command that was printed behind some words."""
    found = [line.partition(before)[2] for line in capsys.readouterr().out.splitlines() if before in line]
    assert len(found) == 1
    return found[0]


@pytest.mark.parametrize("existing", ["my_detector.py", "test_my_detector.py"])
def test_nothing_is_overwritten(existing: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path(existing).write_text("mine")
    assert main(["new-stage", "plane", "my_detector"]) == 2
    assert capsys.readouterr().err.startswith(f"{existing} already exists\n")
    assert [(p.name, p.read_text()) for p in Path().iterdir()] == [(existing, "mine")]


def test_a_name_that_is_taken_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "plane", "ica"]) == 2
    assert capsys.readouterr().err == "'plane.ica' already exists\n  choose another name\n"


@pytest.mark.parametrize("name", ["run_", "my_2d", "a__b"])
def test_a_name_that_its_class_would_not_have_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "plane", name]) == 2
    assert capsys.readouterr().err.startswith(f"'{name}' cannot be a name: its class ")
    assert list(Path().iterdir()) == []


def test_the_family_of_adapters_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "adapters", "mine"]) == 2
    assert capsys.readouterr().err == "the family 'adapters' is reserved for adapters\n  choose another family\n"


def test_a_name_that_hides_a_module_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "plane", "numpy"]) == 2
    assert capsys.readouterr().err == (
        "'numpy' is the name of a Python module, which numpy.py would hide from its test\n  choose another name\n"
    )


@pytest.mark.parametrize("name", ["My-Detector", "class", "1st", ""])
def test_a_name_that_cannot_be_one_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-stage", "plane", name]) == 2
    assert capsys.readouterr().err.startswith(f"'{name}' cannot be a name\n")
