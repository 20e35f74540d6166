"""A package that graphnav has never heard of enters by its entry points alone."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
FIXTURE = HERE.parent / "fixtures" / "graphnav_fixture_pkg"
TOYS = HERE.parent / "errors" / "stages.py"
GRAPHNAV = [sys.executable, "-c", "import sys; from graphnav.core.cli import main; sys.exit(main())"]

GRAPH = """\
about: A toy that third-party stages look at.
run: {until_s: 0.5}
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, in: {image: robot.image}}
  plane: {use: toy.detector, in: {flow: flow.flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  diary: {use: fixture_notes.diary, in: {flow: flow.flow}}
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder into which pip has installed the package."""
    source = tmp_path_factory.mktemp("source") / "a package"
    shutil.copytree(FIXTURE, source)
    target = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    if importlib.util.find_spec("hatchling"):  # builds without a network; else pip fetches it
        pip.append("--no-build-isolation")
    done = subprocess.run([*pip, "--target", str(target), str(source)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return target


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a graph that uses the package."""
    (tmp_path / "graph.yaml").write_text(GRAPH)
    return tmp_path


def graphnav(site: Path | None, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the command line where the package is installed, or is not."""
    environment = {**os.environ, "PYTHONPATH": str(site) if site else "", "COLUMNS": "200"}
    return subprocess.run(
        [*GRAPHNAV, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120
    )


def test_its_stages_are_listed_beside_those_that_ship(site: Path, folder: Path) -> None:
    said = graphnav(site, folder, "stages", "plane").stdout
    assert "plane.level" in said
    assert "plane.affine" in said
    assert "of package graphnav-fixture" in graphnav(site, folder, "stages", "fixture_notes.diary").stdout


def test_its_stage_is_swapped_in_and_runs_with_its_own_message_type(site: Path, folder: Path) -> None:
    words = ["graph.yaml", "--plugin", str(TOYS), "--set", "plane=plane.level"]
    done = graphnav(site, folder, "run", *words, "-o", "out", "--no-tap", "--no-pictures")
    assert done.returncode == 0, done.stderr
    assert "plane: toy.detector swapped for plane.level; defaults: value=0.0" in done.stdout
    assert b"diary.note" in (folder / "out" / "run.lcmlog").read_bytes()
    assert "graphnav_fixture_lcm.note_t" in graphnav(site, folder, "types", "note_t").stdout
    for words in (["echo", "diary.note", "out", "-n", "1", "--field", "text"], ["spy", "out", "--once"]):
        shown = graphnav(site, folder, *words)
        assert "text" in shown.stdout, shown.stderr


def test_without_it_the_graph_is_refused(folder: Path) -> None:
    done = graphnav(None, folder, "check", "graph.yaml", "--plugin", str(TOYS))
    assert done.returncode == 2
    assert "graph.yaml:8:16: there is no family 'fixture_notes'" in done.stderr
