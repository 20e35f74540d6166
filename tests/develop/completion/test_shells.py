"""TAB in a real bash, zsh and fish."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.develop.completion import SHELLS, shell_script
from graphnav.develop.completion.index import installed_index

from .terminal import Terminal

START = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], "PS1='READ''Y> '; source <(graphnav completion bash)"),
    "zsh": (
        ["zsh", "-f", "-i"],
        "PROMPT='READ''Y> '; autoload -U compinit && compinit -u -D; source <(graphnav completion zsh)",
    ),
}
READY = "READY> "


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return variables with graphnav in the path and an index that is already built."""
    cache = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(cache))
        installed_index()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    kept = {key: os.environ[key] for key in ("HOME", "LANG", "LC_ALL") if key in os.environ}
    return {**kept, "PATH": path, "TERM": "xterm", "XDG_CACHE_HOME": str(cache), "COLUMNS": "100"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a working folder with a graph and a run."""
    tmp_path = tmp_path_factory.mktemp("work")
    (tmp_path / "mine.yaml").write_text("stages:\n  see: {use: plane.ica}\n  move: {use: control.wander}\n")
    (tmp_path / "runs" / "first").mkdir(parents=True)
    (tmp_path / "runs" / "first" / "run.lcmlog").touch()
    return tmp_path


def needs(shell: str) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed: apt install {shell}")
    if shutil.which("graphnav", path=str(Path(sys.executable).parent)) is None:
        pytest.skip("the command 'graphnav' is not beside this Python: pip install -e .")


@pytest.fixture(scope="module", params=sorted(START))
def shell(request: pytest.FixtureRequest, folder: Path, environment: dict[str, str]) -> Iterator[Terminal]:
    """Return a shell that has read the script."""
    needs(request.param)
    command, setup = START[request.param]
    terminal = Terminal(command, folder, environment)
    try:
        terminal.press(f"{setup}\n")
        terminal.wait_for(READY)
        yield terminal
    finally:
        terminal.close()


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("graphnav dra", "w "),
        ("graphnav stages world.rob", "ot "),
        ("graphnav run corridor_cc", "w "),
        ("graphnav check mi", "ne.yaml "),
        ("graphnav ablate driving_c", "onditions "),
        ("graphnav types Guard", "State "),
        ("graphnav echo robot.tru", "th "),
        ("graphnav info runs/fir", "st "),
        ("graphnav draw pillars --format merm", "aid "),
        ("graphnav run corridor_ccw --set plane=plane.af", "fine "),
        ("graphnav run mine.yaml --set see=plane.af", "fine "),
        ("graphnav run corridor_ccw --set robot.map=maps/cross", "ing.yaml "),
        ("graphnav ablate corridor_ccw --vary plane=plane.ica,plane.af", "fine "),
    ],
)
def test_tab_completes(shell: Terminal, typed: str, completed: str) -> None:
    shell.press(f"{typed}\t")
    shell.wait_for(typed)
    shell.wait_for(completed)
    shell.press("\x15\n")  # clears the line
    shell.wait_for(READY)


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("graphnav dra", {"draw"}),
        ("graphnav run corridor_", {"corridor_ccw", "corridor_cw"}),
        (
            "graphnav run corridor_ccw --set plane=plane.a",
            {"plane=plane.affine", "plane=plane.all_ground", "plane=plane.appearance"},
        ),
        ("graphnav run mine.yaml --set s", {"see=", "see."}),
        ("graphnav info runs/f", {"runs/first"}),
    ],
)
def test_fish_completes(folder: Path, environment: dict[str, str], typed: str, expected: set[str]) -> None:
    needs("fish")
    ask = f"graphnav completion fish | source; complete -C '{typed}'"
    done = subprocess.run(
        ["fish", "-N", "-c", ask], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    assert {line.partition("\t")[0] for line in done.stdout.splitlines()} == expected


@pytest.mark.parametrize("shell_name", SHELLS)
def test_the_script_names_the_program(shell_name: str) -> None:
    assert "graphnav" in shell_script(shell_name)
