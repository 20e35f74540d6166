"""The README is correct: its commands run, its lists are complete."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
import yaml

from graphnav import __version__
from graphnav.core.cli import commands
from graphnav.core.graph import shipped_graphs

from .conftest import DOCS, blocks, shell, shortened, write_files

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
MAX_WORDS = 400
"""Outside code."""
MAX_PICTURE_BYTES = 2_000_000


@pytest.mark.long
def test_the_graph_and_the_stage_drive_and_the_commands_run(tmp_path: Path, group: str) -> None:
    """As they stand: the first drive is not shortened, since it has to arrive."""
    write_files(ROOT / "README.md", tmp_path)
    [block] = blocks(ROOT / "README.md", "sh")
    first, rest = block.split("\n", 1)
    assert "goal reached" in shell(first, tmp_path, group, forks=False)
    shell(shortened(rest), tmp_path, group)


def test_the_page_is_short_and_hides_nothing() -> None:
    text = re.sub(r"^```.*?^```|\]\([^)]*\)", "", README, flags=re.DOTALL | re.MULTILINE)
    assert len(re.findall(r"\w[\w'./-]*", text)) <= MAX_WORDS
    assert "<!--" not in README


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
        assert 0 < (ROOT / path).stat().st_size < MAX_PICTURE_BYTES, path


def test_the_changelog_names_every_command() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text()
    assert all(re.search(rf"`{command}\b", changelog) for command in commands())


def test_every_file_names_the_same_version() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert project["version"] == citation["version"] == __version__
    assert f"# Changelog\n\n## {__version__} ({citation['date-released']})\n" in changelog
