"""Each room can be deleted: ``graphnav run`` and the core's tests pass without it, and its commands are gone."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from collections.abc import Collection
from pathlib import Path

import pytest

from graphnav.core.cli import COMMANDS
from graphnav.core.rooms import ROOMS

ROOT = Path(__file__).resolve().parent.parent
TESTED = ("stage", "codec")
"""Folders of the core's tests that take little time."""
IMPORTED = """
import importlib, pkgutil, graphnav.core
for module in pkgutil.walk_packages(graphnav.core.__path__, "graphnav.core."):
    importlib.import_module(module.name)
"""


def tree_without(rooms: Collection[str], folder: Path) -> Path:
    """Copy graphnav without some rooms into a folder, with what Python has compiled; return the folder."""
    shutil.copytree(ROOT / "graphnav", folder / "graphnav")
    for room in rooms:
        shutil.rmtree(folder / "graphnav" / room)
    return folder


def python(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run Python where that copy is imported."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("room", ROOMS)
def test_a_graph_runs_without_a_room(room: str, tmp_path: Path) -> None:
    tree = tree_without([room], tmp_path)
    lacking = importlib.import_module(f"graphnav.{room}").COMMANDS
    listed = python(tree, "-m", "graphnav", "--help").stdout
    assert not [name for name in lacking if f"\n    {name} " in listed]
    assert all(f"\n    {name} " in listed for name in COMMANDS)
    done = python(tree, "-m", "graphnav", "run", "corridor_ccw", "--until", "0.2", "--no-pictures", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert (tree / "out" / "run.lcmlog").stat().st_size > 0


def test_what_needs_a_room_says_so(tmp_path: Path) -> None:
    tree = tree_without(["live"], tmp_path)
    done = python(tree, "-m", "graphnav", "run", "navigate_live", "--until", "0.2", "--no-tap")
    assert done.returncode == 1
    assert done.stderr.endswith("this needs graphnav.live, which is not installed\n  install graphnav again\n")


@pytest.mark.long
def test_the_core_is_tested_without_all_rooms(tmp_path: Path) -> None:
    tree = tree_without(ROOMS, tmp_path)
    done = python(tree, "-c", IMPORTED)
    assert done.returncode == 0, done.stderr
    _test(tree, "-m", "not long", *(f"tests/core/{name}" for name in TESTED))


@pytest.mark.slow
def test_all_of_the_core_is_tested_without_all_rooms(tmp_path: Path) -> None:
    _test(tree_without(ROOMS, tmp_path), "-n", "2", "tests/core")


def _test(tree: Path, *words: str) -> None:
    """Run tests of the core where that copy is imported, and see that they pass."""
    for part in ("core", "errors", "fixtures"):
        shutil.copytree(ROOT / "tests" / part, tree / "tests" / part)
    for name in (
        "tests/conftest.py",
        "tests/targets.py",
        "tests/forked_commands.py",
        "tests/ros_bags.py",
        "pyproject.toml",
        "README.md",
    ):
        shutil.copy2(ROOT / name, tree / name)
    (tree / "tools").mkdir()
    done = python(tree, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words)
    assert done.returncode == 0, done.stdout[-4000:]
    print(done.stdout.splitlines()[-1])
