"""The README is correct: its commands run, its lists are complete."""

from __future__ import annotations

import os
import re
import subprocess
import sysconfig
import tomllib
from pathlib import Path

import pytest
import yaml

from graphnav import __version__
from graphnav.cli import COMMANDS
from graphnav.graph import shipped_graphs

from .conftest import DOCS, blocks, patient, shortened

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"^```sh\n(.*?)^```", README, re.DOTALL | re.MULTILINE)


@pytest.mark.long
@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.split("#")[0].strip().replace("/", "_")[:40])
def test_the_commands_run(block: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    if "graphnav spy" in block:
        request.getfixturevalue("group")
    path = f"{sysconfig.get_path('scripts')}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-eu", "-o", "pipefail", "-c", patient(shortened(block))],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_first_two_lines_set_up_and_run_everything() -> None:
    lines = re.findall(r"^python3 -m venv .*$", README, re.MULTILINE)
    assert len(lines) == 2
    assert lines[0].endswith("graphnav run corridor_ccw")
    assert lines[1] in (ROOT / ".ci" / "run").read_text()


def test_the_graph_is_the_one_that_ships() -> None:
    """The graph that the book explains leaves out scores only."""
    block = next(block for block in blocks(DOCS / "howto" / "swap.md", "yaml") if "robot:" in block)
    shown, shipped = yaml.safe_load(block), yaml.safe_load(shipped_graphs()["corridor_ccw"].read_text())
    assert shown["run"] == shipped["run"]
    left_out = set(shipped["stages"]) - set(shown["stages"])
    assert all(shipped["stages"][name]["use"].startswith("score.") for name in left_out)
    assert shown["stages"] == {name: stage for name, stage in shipped["stages"].items() if name not in left_out}


def test_the_pictures_are_there() -> None:
    for path in re.findall(r"!\[[^]]*\]\(([^)]*)\)", README):
        assert (ROOT / path).is_file(), path


def test_the_changelog_names_every_command() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text()
    assert all(re.search(rf"`{command}\b", changelog) for command in COMMANDS)


def test_every_file_names_the_same_version() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert project["version"] == citation["version"] == __version__
    assert f"# Changelog\n\n## {__version__} ({citation['date-released']})\n" in changelog
