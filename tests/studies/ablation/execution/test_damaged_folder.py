"""A study's folder whose files hold anything: it is read, or refused in one line that names the file."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.cli import main
from graphnav.core.errors import UserError
from graphnav.studies.ablation.execution.study_folder import read_plan
from graphnav.studies.ablation.plan.plan import Plan
from graphnav.studies.ablation.plan.plan_file import save_plan
from graphnav.studies.ablation.results.records import read_records

SUMMARY: dict[str, Any] = {
    "outcome": "goal",
    "failure": "",
    "frames": 10,
    "sim_s": 0.9,
    "scores": {"drive": {"success": 1.0, "spl": 0.5}},
    "wall_s": 0.1,
    "stages": {"plane": {"steps": 9, "p50_ms": 1.0, "p99_ms": 2.0}},
}
ODD: tuple[Any, ...] = (None, True, -1, 10**400, 1e308, float("inf"), "", "\ud800", "../x", [], [[1]], {}, {"a": {}})


def _places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value in JSON data."""
    yield path
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in inner:
        yield from _places(value, (*path, key))


def _damaged(data: Any) -> Iterator[str]:
    """Yield JSON in which one value is odd, or missing."""
    for path in _places(data):
        for odd in (*ODD, _damaged):
            changed = copy.deepcopy({"": data})
            *way, last = ("", *path)
            parent: Any = changed
            for key in way:
                parent = parent[key]
            if odd is _damaged:
                del parent[last]
            else:
                parent[last] = odd
            yield json.dumps(changed.get("", {}))


@pytest.fixture
def folder(tmp_path: Path, make_plan: Callable[..., Plan]) -> Path:
    save_plan(make_plan(metrics={"drive.success": "higher"}, seeds=(0,)), tmp_path / "plan.json")
    for variant in ("ica", "affine"):
        run = tmp_path / "corridor" / variant / "0"
        run.mkdir(parents=True)
        (run / "summary.json").write_text(json.dumps(SUMMARY))
    return tmp_path


def _refusal(read: Callable[[], object]) -> str:
    """Return the error with which a user's file is refused, empty if it is accepted; other exceptions pass."""
    try:
        read()
    except UserError as error:
        return str(error)
    return ""


def test_any_value_of_a_plan_may_be_odd(folder: Path) -> None:
    path = folder / "plan.json"
    for text in list(_damaged(json.loads(path.read_text()))):
        path.write_text(text)
        refusal = _refusal(lambda: read_records(read_plan(folder), folder))
        assert refusal == "" or refusal.startswith(str(path)), text


def test_any_value_of_a_summary_may_be_odd(folder: Path) -> None:
    plan, path = read_plan(folder), folder / "corridor" / "affine" / "0" / "summary.json"
    for text in _damaged(SUMMARY):
        path.write_text(text)
        refusal = _refusal(lambda: read_records(plan, folder))
        assert refusal == "" or "summary.json is not a complete summary of a run" in refusal, text


@pytest.mark.parametrize("name", ["plan.json", "corridor/ica/0/summary.json"])
def test_deep_nesting_is_refused(folder: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / name).write_text("[" * 200_000)
    assert main(["ablate", "--report", str(folder)]) == 2
    assert capsys.readouterr().err.startswith(str(folder / name))
