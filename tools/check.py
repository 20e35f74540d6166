"""Run all checks of CI in order: format, lint, types, architecture, docs, tests; or ``quick``, those of a change."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path, PurePath

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = Path(sysconfig.get_path("scripts"))
CHECKED = ["graphnav", "plugins", "tests", "tools", "docs/conf.py"]
WORKERS = 2 * (os.cpu_count() or 1)
"""Processes of the tests: live ones mostly wait for what others send, so that two share a core."""
TESTS = [sys.executable, "-m", "pytest", "-q", "-n", str(WORKERS)]

STEPS: dict[str, list[str]] = {
    "format": [sys.executable, "-m", "ruff", "format", "--check", "--quiet", *CHECKED],
    "lint": [sys.executable, "-m", "ruff", "check", "--quiet", *CHECKED],
    "types": [sys.executable, "-m", "mypy", *CHECKED],
    "architecture": [str(SCRIPTS / "lint-imports"), "--no-logo"],
    "docs": [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "--nitpicky",
        "--quiet",
        "--fresh-env",
        "docs",
        "build/docs",
    ],
    "tests": [*TESTS, "--dist", "worksteal"],
}
TESTING = ("tests", "changed")
BESIDE = ("types", "docs")
"""Steps that take minutes of one core: they take what the tests leave, which often wait, and are told after them."""
QUICK = ["format", "lint", "types", "architecture", "changed"]
"""The steps of ``quick``; types take no time where mypy has its cache."""
WITHIN_S = 30
"""How long ``changed`` goes on starting tests."""
TESTS_FAILED, NO_TESTS = 1, 5
"""Status of pytest where tests failed, and where all take long."""
FEW = 5
"""So many failed tests, at most, run again alone: on a machine that others load, one that waits may wait too long."""

CORE = [f"tests/core/{name}" for name in ("spec", "graph", "catalog", "stage", "messages", "codec", "record", "runner")]
"""Tests that ``changed`` runs where no test belongs to what has changed."""
OF_DATA = {
    "docs": ["tests/test_words.py"],
    "graphs": ["tests/contract", "tests/closed_loop/test_suite.py"],
    "lcmtypes": ["tests/lcm/test_types.py", "tests/core/codec"],
}
"""Tests of files that are not Python, by folder."""


def changed_files(root: Path) -> list[str]:
    """Return the files that differ from where this branch left ``main``, those included that are not in Git yet."""

    def git(*words: str) -> list[str]:
        done = subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=False)
        return done.stdout.splitlines()

    bases = (git("merge-base", "HEAD", branch) for branch in ("main", "origin/main"))
    base = next((found[0] for found in bases if found), "HEAD")
    return [*git("diff", "--name-only", base), *git("ls-files", "--others", "--exclude-standard")]


def tests_of(changed: Iterable[str], root: Path) -> list[str]:
    """Return the tests of files that have changed, the nearest first; those of the core if there are none.

    Nearest are tests that have changed, then those in the folder of the same name, then those that import the changed
    module, then those that import its package.
    """
    texts = {str(path.relative_to(root)): path.read_text() for path in sorted(root.glob("tests/**/test_*.py"))}
    ranks: list[set[str]] = [set(), set(), set(), set()]
    for path in map(PurePath, changed):
        if str(path) in texts:
            ranks[0].add(str(path))
        elif path.suffix != ".py":
            ranks[1].update(OF_DATA.get(path.parts[0], ()))
        else:
            mirror, module = _mirror(path, root), _module(path)
            is_room = len(PurePath(mirror).parts) == 2  # of a module that is in no folder of it: not all its tests
            ranks[1].update(
                test for test in texts if mirror in map(str, list(PurePath(test).parents)[: 1 if is_room else None])
            )
            package = module.rpartition(".")[0]
            for rank, name in ((2, module), (3, package if "." in package else module)):
                importing = re.compile(rf"^\s*(from|import) {re.escape(name)}\s", re.MULTILINE)
                ranks[rank].update(test for test, text in texts.items() if importing.search(text))
    return list(dict.fromkeys(test for rank in ranks for test in sorted(rank))) or CORE


def _mirror(path: PurePath, root: Path) -> str:
    """Return the folder of a module's tests: of ``graphnav/a/b/c.py`` ``tests/a/b``, or else ``tests/a``.

    Of a helper among the tests it is its own folder. An empty string where there is none.
    """
    first, *inner = path.parent.parts or ("",)
    if first == "plugins" and inner:
        first, inner = f"plugins/{inner[0].removeprefix('graphnav_')}", inner[1:]
    elif first == "graphnav" and inner:
        first, inner = inner[0], inner[1:]
    elif first == "tests":
        return str(path.parent) if inner else ""
    while inner and not (root / "tests" / first / "/".join(inner)).is_dir():
        inner.pop()
    folder = PurePath("tests", first, *inner)
    return str(folder) if (root / folder).is_dir() and len(folder.parts) > 1 else ""


def _module(path: PurePath) -> str:
    """Return the name by which tests import a file."""
    parts = path.parts[1:] if path.parts[0] in ("plugins", "lcmtypes", "graphs", "tools") else path.parts
    return ".".join(parts).removesuffix(".py").removesuffix(".__init__")


def are_compiled(root: Path) -> bool:
    """Whether pytest has compiled most of the tests, by this Python and for its own version."""
    suffix = f"{sys.implementation.cache_tag}-pytest-{version('pytest')}.pyc"
    tests = list(root.glob("tests/**/test_*.py"))
    return 2 * sum((path.parent / "__pycache__" / f"{path.stem}.{suffix}").exists() for path in tests) > len(tests)


def command_of(step: str) -> list[str]:
    """Return the command of a step; ``changed`` leaves out tests that take long, and what would begin too late."""
    if step != "changed":
        return STEPS[step]
    tests = tests_of(changed_files(ROOT), ROOT)
    print(f"tests of what has changed since main: {len(tests)} files and folders", flush=True)
    options = ["-p", "no:randomly", "--dist", "load", "-m", "not long", "--within-s", str(WITHIN_S), "-rs"]
    return [*TESTS, *options, *tests]


def _run(step: str, *, is_shown: bool) -> tuple[bool, str]:
    """Run a step; return whether it failed, and what it printed unless that ``is_shown`` meanwhile."""
    begin = time.monotonic()
    where = None if is_shown else subprocess.PIPE
    errors = None if is_shown else subprocess.STDOUT
    gives_way = ["nice", "-n", "19"] if step in BESIDE and shutil.which("nice") else []
    command = [*gives_way, *command_of(step)]
    done = subprocess.run(command, cwd=ROOT, env=_environment(), stdout=where, stderr=errors, text=True, check=False)
    has_failed = done.returncode != 0 and not (step == "changed" and done.returncode == NO_TESTS)
    told = ""
    if step == "tests" and done.returncode == TESTS_FAILED and 0 < len(failed := last_failed(ROOT)) <= FEW:
        print("== alone: what failed beside others", flush=True)
        alone = [sys.executable, "-m", "pytest", "-q", "-p", "no:xdist", *failed]
        has_failed = subprocess.run(alone, cwd=ROOT, env=_environment(), check=False).returncode != 0
        told = "" if has_failed else f", but failed beside others and passed alone: {', '.join(failed)}"
    verdict = f"== {step}: {'FAILED' if has_failed else 'ok'}, {time.monotonic() - begin:.0f} s{told}\n"
    return has_failed, (done.stdout or "") + verdict


def last_failed(root: Path) -> list[str]:
    """Return the tests that failed when pytest last ran."""
    try:
        return list(json.loads((root / ".pytest_cache/v/cache/lastfailed").read_text()))
    except FileNotFoundError:
        return []


def _environment() -> dict[str, str]:
    """Return the environment of a step: tests start some hundred processes, each of which would compile the package."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def _compile_tests() -> None:
    """Collect the tests once where they are not compiled: workers, which begin at the same time, would each do so."""
    if not are_compiled(ROOT):
        collect = [sys.executable, "-m", "pytest", "--collect-only", "-qq"]
        subprocess.run(collect, cwd=ROOT, env=_environment(), capture_output=True, check=False)


def main() -> int:
    """Run the steps named on the command line, else all of CI; return 1 if one failed.

    Steps without tests use one core each, so that several run at once; those that take long go on beside the tests.
    """
    wanted = [step for name in sys.argv[1:] for step in (QUICK if name == "quick" else [name])] or list(STEPS)
    if unknown := [name for name in wanted if name not in (*STEPS, "changed")]:
        print(f"no step {', '.join(unknown)}: steps are {', '.join((*STEPS, 'changed', 'quick'))}", file=sys.stderr)
        return 2
    failed = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        last = BESIDE if "tests" in wanted else ()
        order = sorted(wanted, key=lambda step: (step in last, step in TESTING))
        compiling = pool.submit(_compile_tests) if "tests" in wanted else None
        begun = {step: pool.submit(_run, step, is_shown=False) for step in order if step not in TESTING}
        for step in order:
            if step == "tests" and compiling:
                compiling.result()
            print(f"== {step}", flush=True)
            has_failed, printed = begun[step].result() if step in begun else _run(step, is_shown=True)
            print(printed, end="", flush=True)
            failed += [step] if has_failed else []
    print(f"failed: {', '.join(failed)}" if failed else "all ok")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
