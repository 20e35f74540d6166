"""``tools/check.py quick`` runs the tests of what has changed, the nearest first, and begins none too late."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import check
import pytest

FILES = {
    "graphnav/a/b/c.py": "",
    "graphnav/solo.py": "",
    "plugins/graphnav_world/maps/keys.py": "",
    "tools/gen.py": "",
    "tests/a/b/test_near.py": "",
    "tests/a/test_above.py": "import graphnav.a.b.other\n",
    "tests/lcm/test_user.py": "from graphnav.a.b.c import name\n",
    "tests/lcm/test_of_package.py": "def test() -> None:\n    from graphnav.a.b import name\n",
    "tests/lcm/helper.py": "",
    "tests/plugins/world/test_maps.py": "",
    "tests/test_solo.py": "from graphnav.solo import name\n",
    "tests/test_all.py": "from graphnav import name\n",
    "tests/test_gen.py": "import gen\n",
}


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Return a tree of a few modules and their tests."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("changed", "tests"),
    [
        (["graphnav/a/b/c.py"], ["a/b/test_near.py", "lcm/test_user.py", "lcm/test_of_package.py"]),
        (["graphnav/a/b/deep/gone.py"], ["a/b/test_near.py"]),
        (["graphnav/a/new.py"], ["a/test_above.py"]),
        (["graphnav/solo.py"], ["test_solo.py"]),
        (["plugins/graphnav_world/maps/keys.py"], ["plugins/world/test_maps.py"]),
        (["tools/gen.py"], ["test_gen.py"]),
        (["tests/lcm/helper.py"], ["lcm/test_of_package.py", "lcm/test_user.py"]),
        (["graphnav/a/b/c.py", "tests/test_gen.py"], ["test_gen.py", "a/b/test_near.py", "lcm/test_user.py"]),
        (["docs/index.md"], ["test_words.py"]),
    ],
)
def test_the_nearest_tests_come_first(tree: Path, changed: list[str], tests: list[str]) -> None:
    found = check.tests_of(changed, tree)
    assert found[: len(tests)] == [f"tests/{name}" for name in tests]
    assert len(changed) > 1 or len(found) == len(tests)


@pytest.mark.parametrize("changed", [[], ["tests/conftest.py"], ["pyproject.toml"]])
def test_what_belongs_to_no_folder_is_checked_by_the_core(tree: Path, changed: list[str]) -> None:
    assert check.tests_of(changed, tree) == check.CORE
    data = [test for tests in check.OF_DATA.values() for test in tests]
    assert [test for test in (*check.CORE, *data) if not (check.ROOT / test).exists()] == []


def test_changed_is_what_differs_from_where_the_branch_left_main(tree: Path) -> None:
    def git(*words: str) -> None:
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *who, *words], cwd=tree, check=True, capture_output=True)

    git("init", "-q", "-b", "main")
    git("add", ".")
    git("commit", "-q", "-m", "all")
    assert check.changed_files(tree) == []
    git("checkout", "-q", "-b", "mine")
    (tree / "tools/gen.py").write_text("committed = 1\n")
    git("commit", "-q", "-a", "-m", "mine")
    (tree / "graphnav/solo.py").write_text("changed = 1\n")
    (tree / "graphnav/new.py").touch()
    git("checkout", "-q", "main", "--", "tests")
    assert check.changed_files(tree) == ["graphnav/solo.py", "tools/gen.py", "graphnav/new.py"]


def test_tests_are_compiled_where_pytest_has_collected_them(tree: Path) -> None:
    assert not check.are_compiled(tree)
    for path in tree.glob("tests/**/test_*.py"):
        path.write_text("def test() -> None: ...\n")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-m", "pytest", "--collect-only", "-qq", "tests"]
    subprocess.run(command, cwd=tree, env=environment, check=True, capture_output=True)
    assert check.are_compiled(tree)


def test_an_unknown_step_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["check.py", "quick", "test"])
    assert check.main() == 2
    assert capsys.readouterr().err == (
        "no step test: steps are format, lint, types, architecture, docs, tests, changed, quick\n"
    )


def test_modules_that_take_long_come_first_and_what_is_late_does_not_begin() -> None:
    files = ["tests/core/test_shown_name.py", "tests/core/machine/test_instruction_set.py"]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-v",
        "-rs",
        "-p",
        "no:randomly",
        "-p",
        "no:xdist",
        "--within-s",
        "0",
        *files,
    ]
    environment = {**os.environ, "PYTEST_XDIST_WORKER_COUNT": "2"}
    done = subprocess.run(command, cwd=check.ROOT, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, "not begun in time" in done.stdout) == (0, True), done.stdout
    lines = [line for line in done.stdout.splitlines() if "::" in line]
    assert all("SKIPPED" in line for line in lines)
    assert [line.startswith(files[1]) for line in (lines[0], lines[-1])] == [True, False]


def test_what_a_step_prints_stays_together_and_a_failure_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    steps = {"docs": "print('fine')", "types": "import sys; print('bad', file=sys.stderr); sys.exit(3)"}
    monkeypatch.setattr(check, "STEPS", {name: [sys.executable, "-c", code] for name, code in steps.items()})
    monkeypatch.setattr(sys, "argv", ["check.py"])
    assert check.main() == 1
    printed = re.sub(r"\d+ s", "0 s", capsys.readouterr().out)
    assert printed == ("== docs\nfine\n== docs: ok, 0 s\n== types\nbad\n== types: FAILED, 0 s\nfailed: types\n")


@pytest.mark.parametrize(("alone", "status"), [("first", 0), ("never", 1)])
def test_a_test_that_fails_beside_others_runs_again_alone_and_is_named(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path, alone: str, status: int
) -> None:
    (tmp_path / "test_it.py").write_text(
        "import pathlib\nran = pathlib.Path(__file__).with_name('ran')\n"
        "def test_good(): ...\n"
        "def test_late():\n    before = ran.exists()\n    ran.touch()\n"
        f"    assert before and {alone!r} == 'first'\n"
    )
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.setattr(check, "ROOT", tmp_path)
    monkeypatch.setattr(check, "STEPS", {"tests": [sys.executable, "-m", "pytest", "-q"]})
    monkeypatch.setattr(check, "are_compiled", lambda _: True)
    monkeypatch.setattr(sys, "argv", ["check.py"])
    assert check.main() == status
    printed = capfd.readouterr().out
    assert ("failed beside others and passed alone: test_it.py::test_late\nall ok" in printed) == (status == 0)
    assert [line.partition(" in ")[0] for line in printed.splitlines() if " in " in line] == [
        "1 failed, 1 passed",
        "1 failed" if status else "1 passed",
    ], "alone runs only what failed"
