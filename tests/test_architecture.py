"""The architecture holds, and every contract is seen to fail when it is broken on purpose."""

from __future__ import annotations

import ast
import importlib
import os
import re
import shutil
import subprocess
import sysconfig
import tomllib
from itertools import zip_longest
from pathlib import Path

import pytest
from reference_pages.doors import doors

import graphnav

ROOT = Path(__file__).resolve().parent.parent

BREAKS = {
    "layers": ("graphnav/core/messages/message.py", "import graphnav.core.graph", "Imports in the core point down"),
    "layers-exhaustive": ("graphnav/core/stray.py", "", "Imports in the core point down"),
    "rooms": ("graphnav/core/api/run.py", "import graphnav.live.run", "Rooms use the core and do not know each other"),
    "rooms-apart": (
        "graphnav/watch/feed/feed.py",
        "import graphnav.live.run",
        "Rooms use the core and do not know each other",
    ),
    "rooms-exhaustive": ("graphnav/stray.py", "", "Rooms use the core and do not know each other"),
    "core": ("graphnav/core/runner/unit.py", "import cv2", "The core knows no algorithm and no plugin"),
    "core-plugin": (
        "graphnav/core/report/summary_text.py",
        "import graphnav_plane",
        "The core knows no algorithm and no plugin",
    ),
    "plugins": ("plugins/graphnav_plane/__init__.py", "import graphnav_flow", "Plugins do not import each other"),
    "authoring": (
        "plugins/graphnav_steer/__init__.py",
        "import graphnav.core.runner",
        "Plugins use only the authoring API",
    ),
    "authoring-grid": (
        "plugins/graphnav_steer/__init__.py",
        "from graphnav.core.grid import coarsen",
        "Plugins use only the authoring API",
    ),
    "doors": (
        "graphnav/live/outlet.py",
        "import graphnav.core.runner.engine",
        "The core is used through what its folders export",
    ),
    "doors-deeper": (
        "graphnav/studies/table.py",
        "from graphnav.core.graph.wiring.wires import *",
        "The core is used through what its folders export",
    ),
    "runner": (
        "graphnav/core/runner/engine.py",
        "import graphnav.core.runner.lockstep",
        "The engine knows no schedule",
    ),
    "runner-exhaustive": ("graphnav/core/runner/stray.py", "", "The engine knows no schedule"),
    "lcm": ("graphnav/core/runner/unit.py", "import lcm", "LCM is imported by bus only"),
    "ablation": (
        "graphnav/studies/ablation/plan/plan.py",
        "import graphnav.studies.ablation.results",
        "Imports in ablation point down",
    ),
    "ablation-siblings": (
        "graphnav/studies/ablation/execution/workers.py",
        "import graphnav.studies.ablation.report",
        "Imports in ablation point down",
    ),
    "ablation-exhaustive": ("graphnav/studies/ablation/stray.py", "", "Imports in ablation point down"),
    "ablation-report": (
        "graphnav/studies/ablation/report/legend.py",
        "import graphnav.studies.ablation.report.markdown",
        "Imports in the report of a study point down",
    ),
    "ablation-report-exhaustive": (
        "graphnav/studies/ablation/report/stray.py",
        "",
        "Imports in the report of a study point down",
    ),
    "ablation-html": (
        "graphnav/studies/ablation/report/html/charts/scale.py",
        "import graphnav.studies.ablation.report.html.plots",
        "Imports in the HTML report point down",
    ),
    "ablation-html-exhaustive": (
        "graphnav/studies/ablation/report/html/stray.py",
        "",
        "Imports in the HTML report point down",
    ),
    "ablation-acyclic": (
        "graphnav/studies/ablation/study/worlds.py",
        "import graphnav.studies.ablation.study.study_file",
        "No folder in ablation has a cycle",
    ),
    "ablation-exports": (
        "graphnav/studies/api/study_request.py",
        "import graphnav.studies.ablation.plan.variants",
        "Ablations are used through what their folders export",
    ),
}


def lint(root: Path) -> subprocess.CompletedProcess[str]:
    """Run the contracts of the tree at ``root``."""
    paths = os.pathsep.join(str(root / part) for part in (".", "plugins", "lcmtypes", "graphs"))
    command = [str(Path(sysconfig.get_path("scripts")) / "lint-imports"), "--no-cache"]
    environment = {**os.environ, "PYTHONPATH": paths, "COLUMNS": "200"}
    return subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Return a copy of the source tree."""
    for part in ("graphnav", "plugins", "lcmtypes"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_contracts_hold(tree: Path) -> None:
    done = lint(tree)
    assert done.returncode == 0, done.stdout + done.stderr


def rounds() -> list[list[str]]:
    """Return the names of the breaks in as few rounds as break each contract once."""
    of_contract: dict[str, list[str]] = {}
    for name, (_, _, contract) in BREAKS.items():
        of_contract.setdefault(contract, []).append(name)
    return [[name for name in names if name] for names in zip_longest(*of_contract.values())]


@pytest.mark.parametrize("names", rounds(), ids="+".join)
def test_a_broken_contract_is_seen(tree: Path, names: list[str]) -> None:
    for name in names:
        path, line, _ = BREAKS[name]
        broken = tree / path
        text = broken.read_text() if broken.exists() else '"""A module outside of the layers."""\n'
        broken.write_text(f"{text}\n{line}\n")
    done = lint(tree)
    assert done.returncode == 1, done.stdout + done.stderr
    verdicts, _, details = done.stdout.partition("Broken contracts")
    for path, _, contract in map(BREAKS.__getitem__, names):
        assert f"{contract} BROKEN" in " ".join(verdicts.split())
        broken = tree / path
        reason = details.partition(f"\n{contract}\n")[2].partition("\n\n\n")[0]
        assert (broken.parent.name if broken.stem == "__init__" else broken.stem) in reason


CORE = sorted((ROOT / "graphnav").rglob("*.py"))
MAX_FUNCTION_LINES = 50


def test_functions_of_the_core_are_short() -> None:
    long = [
        f"{path.relative_to(ROOT)}: {node.name} has {node.end_lineno - node.lineno + 1} lines"
        for path in CORE
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.end_lineno is not None
        if node.end_lineno - node.lineno >= MAX_FUNCTION_LINES
    ]
    assert not long, f"split them; the docstring counts, too: {long}"


def test_every_package_that_ships_is_typed() -> None:
    packages = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"][
        "packages"
    ]
    assert [package for package in packages if not (ROOT / package / "py.typed").is_file()] == []


def test_the_walk_through_the_code_visits_every_file_once() -> None:
    walk = (ROOT / "ARCHITECTURE.md").read_text().partition("## A walk through the code")[2]
    files = re.findall(r"^\| `(?:graphnav/)?(\S+\.py)` \|", walk, re.MULTILINE)
    assert len(files) > 20
    assert len(set(files)) == len(files)
    assert [file for file in files if not (ROOT / "graphnav" / file).is_file()] == []


def test_rooms_take_public_names_from_graphnav() -> None:
    public = {name: getattr(graphnav, name) for name in dir(graphnav)}
    taken = [
        f"{module}: {name}"
        for module, names in doors().items()
        for name in names
        if name in public and getattr(importlib.import_module(module), name) is public[name]
    ]
    assert not taken, "import them from graphnav"
