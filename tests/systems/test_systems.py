"""Simulation, studies, replay and export work where what only Linux or Unix has is missing; the rest says so."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import mypy
import pytest
import yaml

HERE = Path(__file__).parent
STUBS = Path(mypy.__file__).parent / "typeshed" / "stdlib"
"""Those of the standard library say which names it has on which system."""
OS_NAMES = {"win32": "nt", "darwin": "posix"}
_ALIKE = "fcntl grp mmap pty pwd resource select signal socket syslog termios time tty"
MODULES = {"curses": "curses/__init__", "os": "os/__init__"} | {name: name for name in _ALIKE.split()}
"""The modules that differ between systems and that graphnav, or who maintains it, may import; the stubs of each."""


def names_in(body: list[ast.stmt], platform: str) -> Iterator[str]:
    """Yield the names that statements of a stub define on a system."""
    system = {"sys": SimpleNamespace(platform=platform, version_info=sys.version_info)}
    for statement in body:
        match statement:
            case ast.If(test=test, body=inner, orelse=other):
                is_so = eval(compile(ast.Expression(test), "stub", "eval"), system)
                yield from names_in(inner if is_so else other, platform)
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.AnnAssign(target=ast.Name(id=name)) | ast.Assign(targets=[ast.Name(id=name)]):
                yield name
            case ast.ImportFrom(names=names):
                yield from (one.asname for one in names if one.asname)


def lacking(platform: str) -> tuple[list[str], dict[str, list[str]]]:
    """Return the modules that a system lacks, and the names that others lack there but have on Linux."""
    modules, names = [], {}
    for module, stub in MODULES.items():
        body = ast.parse((STUBS / f"{stub}.pyi").read_text(encoding="utf-8")).body
        found, here = (set(names_in(body, system)) for system in (platform, "linux"))
        if not found - {"sys"}:
            modules.append(module)
        elif here - found:
            names[module] = sorted(here - found)
    if platform == "win32":
        names.pop("termios", None)
        modules += [name for name in ("curses", "termios", "tty") if name not in modules]  # their stubs do not say so
    return modules, names


@pytest.fixture(params=["win32", pytest.param("darwin", marks=pytest.mark.slow)])
def system(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, str]:
    """Return the environment of processes whose graphnav sees macOS or Windows."""
    modules, names = lacking(request.param)
    file, home = tmp_path / "system.json", tmp_path / "home"
    home.mkdir()
    file.write_text(
        json.dumps(
            {
                "platform": request.param,
                "os_name": OS_NAMES[request.param],
                "modules": modules,
                "names": names,
                "keeps_open": request.param == "win32",
            }
        )
    )
    kept = {name: value for name, value in os.environ.items() if not name.startswith("XDG_")}
    return kept | {
        "GRAPHNAV_TEST_SYSTEM": str(file),
        "PYTHONPATH": str(HERE / "simulated"),
        "HOME": "" if request.param == "win32" else str(home),
        "USERPROFILE": str(home),
        "LC_ALL": "C",  # files without an encoding would be read as ASCII
        "PYTHONCOERCECLOCALE": "0",
        "PYTHONUTF8": "0",
    }


def test_the_simulated_systems_lack_what_those_lack() -> None:
    modules, names = lacking("win32")
    assert {"curses", "fcntl", "grp", "pwd", "resource", "termios", "tty"} <= set(modules)
    assert {"fork", "getuid", "geteuid", "mkfifo", "openpty", "pidfd_open", "sched_getaffinity"} <= set(names["os"])
    assert {"O_NOFOLLOW", "O_NONBLOCK", "killpg", "pread", "writev", "sysconf"} <= set(names["os"])
    assert {"SIGHUP", "SIGUSR1", "SIGALRM", "pthread_sigmask", "setitimer"} <= set(names["signal"])
    assert {"AF_UNIX", "SO_PEERCRED"} <= set(names["socket"])
    assert {"epoll", "poll"} <= set(names["select"])
    modules, names = lacking("darwin")
    assert not modules
    assert {"pidfd_open", "memfd_create", "posix_fallocate"} <= set(names["os"])
    assert "fork" not in names["os"]


@pytest.mark.long
def test_commands_run_or_say_that_they_need_linux(system: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / "empty"
    folder.mkdir()
    command = [sys.executable, str(HERE / "commands.py")]
    done = subprocess.run(command, cwd=folder, env=system, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_workflow_names_both_systems_and_files_that_exist() -> None:
    root = HERE.parents[1]
    text = (root / ".github" / "workflows" / "systems.yml").read_text(encoding="utf-8")
    job = yaml.safe_load(text)["jobs"]["wheel"]
    assert {"macos-latest", "windows-latest"} <= set(job["strategy"]["matrix"]["system"])
    lines = [step["run"] for step in job["steps"] if "run" in step]
    [command] = [line for line in lines if "$GITHUB_WORKSPACE/" in line]
    assert (root / command.partition("$GITHUB_WORKSPACE/")[2].rstrip('"')).samefile(HERE / "commands.py")
