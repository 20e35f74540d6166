"""Fixtures of the documentation tests: commands run as a reader's shell would run them, from forks of one process."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sysconfig
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile

from tests.forked_commands import forked_graphnav

DOCS = Path(__file__).resolve().parents[2] / "docs"


def blocks(document: Path, language: str) -> list[str]:
    """Return the contents of the fenced blocks of a language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```", document.read_text(), re.DOTALL | re.MULTILINE)


def named_blocks(document: Path) -> dict[str, str]:
    """Return the fenced blocks whose first line is a comment that names a file, by that name."""
    found = re.findall(r"^```\w*\n((?:#|//) (\S+\.\w+)\n.*?)^```", document.read_text(), re.DOTALL | re.MULTILINE)
    return {name: text for text, name in found}


def page_script(document: Path) -> str:
    """Return what a reader does: write the files that the page names, run its ``sh`` blocks, in the page's order."""
    found = re.findall(
        r"^```(\w*)\n((?:(?:#|//) (\S+\.\w+)\n)?.*?)^```", document.read_text(), re.DOTALL | re.MULTILINE
    )
    steps = (_writing(name, text) if name else text for language, text, name in found if name or language == "sh")
    return "".join(steps)


def _writing(name: str, text: str) -> str:
    return f"mkdir -p \"$(dirname {name})\"\ncat > {name} <<'END_OF_FILE'\n{text}END_OF_FILE\n"


def write_files(document: Path, folder: Path) -> None:
    """Write the files that a page names."""
    for name, text in named_blocks(document).items():
        (folder / name).write_text(text)


def shortened(script: str) -> str:
    """Return a script that shows that the same commands work, in a fraction of the time.

    Drives in simulated time end after a second, studies are made in two worlds, and one failure of each is drawn.
    """
    lines = []
    for line in script.splitlines():
        if "--pace" not in line and "--live" not in line:
            line = re.sub(r"(--until |until_s=)\d+\b", r"\g<1>1", line)  # noqa: PLW2901
        line = re.sub(r"(--seeds )(\d+):\d+", lambda found: f"{found[1]}{found[2]}:{int(found[2]) + 2}", line)  # noqa: PLW2901
        until = "" if "until_s=" in line else "--set run.until_s=1 "
        lines.append(re.sub(r"^graphnav ablate (?!--)", f"graphnav ablate --gallery 1 {until}", line))
    return "\n".join(lines)


def shell(script: str, folder: Path, url: str, timeout_s: float = 300, *, forks: bool = True) -> str:
    """Run a script in ``folder``, with LCM on ``url``; return what it printed. A command that fails fails the test.

    Programs that it leaves behind are killed. ``forks``: false starts every ``graphnav`` as a reader does.
    """
    scripts = sysconfig.get_path("scripts")
    if forks:
        scripts = f"{forked_graphnav().parent}{os.pathsep}{scripts}"
    with TemporaryFile("w+") as printed:
        started = subprocess.Popen(
            ["bash", "-eu", "-o", "pipefail", "-c", script],
            cwd=folder,
            env={**os.environ, "PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}", "LCM_DEFAULT_URL": url},
            stdout=printed,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            status = started.wait(timeout_s)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(started.pid, signal.SIGKILL)
        printed.seek(0)
        text = printed.read()
    assert status == 0, text
    return text
