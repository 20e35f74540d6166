"""The wheel holds every file that graphnav reads at run time."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
SOURCES = ("graphnav", "plugins", "lcmtypes", "graphs", "pyproject.toml", "README.md", "LICENSE")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a wheel, built from a copy so that the repository stays as it is."""
    pytest.importorskip("hatchling", reason="hatchling builds the wheel: pip install '.[dev]'")
    source = tmp_path_factory.mktemp("source")
    for name in SOURCES:
        if (REPOSITORY / name).is_dir():
            shutil.copytree(REPOSITORY / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(REPOSITORY / name, source / name)
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    done = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


def test_templates_are_package_data(wheel: Path) -> None:
    templates = {
        path.relative_to(REPOSITORY).as_posix()
        for path in (REPOSITORY / "graphnav").rglob("templates/*")
        if path.is_file()
    }
    assert templates
    assert templates <= set(zipfile.ZipFile(wheel).namelist())


def test_every_data_file_is_in_it_and_nothing_that_is_not_of_graphnav(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {
        "graphnav",
        *(
            path.name
            for folder in ("plugins", "lcmtypes", "graphs")
            for path in (REPOSITORY / folder).glob("graphnav_*")
        ),
    }
    for folder in ("graphs", "lcmtypes", "plugins"):
        data = (path for path in (REPOSITORY / folder).glob("graphnav_*/**/*") if path.is_file())
        kept = {p.relative_to(REPOSITORY / folder).as_posix() for p in data if "__pycache__" not in p.parts}
        assert kept <= names
    assert any(name.endswith(".lcm") for name in names)
    assert any(name.startswith("graphnav_graphs/models/") for name in names)
    assert not [name for name in names if "/tests/" in name or name.endswith((".pyc", ".md", ".ipynb"))]


def test_it_declares_what_it_runs_on(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        [path] = [name for name in archive.namelist() if name.endswith("/METADATA")]
        text = archive.read(path).decode()
        assert [name for name in archive.namelist() if name.endswith("dist-info/licenses/LICENSE")]
    for line in (
        "Requires-Python: >=3.11",
        "License-Expression: Apache-2.0",
        "Description-Content-Type: text/markdown",
    ):
        assert f"\n{line}\n" in text
    for system in ("POSIX :: Linux", "MacOS", "Microsoft :: Windows"):
        assert f"\nClassifier: Operating System :: {system}\n" in text
