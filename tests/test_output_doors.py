"""All output goes through the few places that escape it: nothing else writes to a terminal, a page or a report."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphnav.core.rooms import ROOMS

ROOT = Path(__file__).resolve().parent.parent
FILES = [path for folder in ("graphnav", "plugins") for path in sorted((ROOT / folder).rglob("*.py"))]
COMMANDS = ("graphnav/core/cli/", *(f"graphnav/{room}/commands/" for room in ROOMS))
"""Commands print to standard output and error, which ``graphnav.core.cli.main`` has replaced by streams that escape."""
DOORS = {
    "graphnav/core/machine/console.py": "the console that escapes",
    "graphnav/core/machine/escaped_streams.py": "the streams that escape",
    "graphnav/core/notices.py": "escapes what it prints",
    "graphnav/core/html_templates.py": "escapes what templates show",
    "graphnav/studies/ablation/worker/__main__.py": "prints tracebacks to the streams that escape",
    "graphnav/processes/change_run.py": "what three commands share: prints to the streams that escape",
    "graphnav/core/runner/recording/stall.py": "gives faulthandler, which escapes, the stream of the process",
    "graphnav/core/machine/threads.py": "runs after the commands, and escapes the names of threads",
    "graphnav/core/cli/status_line.py": "rewrites a line, and escapes what it shows",
    "graphnav/core/cli/lasting_output.py": "the streams below those that escape",
    "graphnav/watch/commands/spy.py": "asks whether there is a terminal for a full screen, and queries terminfo",
    "graphnav/core/machine/terminal_graphics.py": "queries the terminal with constants",
    "graphnav/watch/spy/screen/plot_view.py": "reads the colours of plots, which contain numbers only",
}
"""Files that may use what escapes nothing, with the reason."""
PRINTS = {"print", "print_exc", "print_exception", "print_stack", "print_tb"}
STREAMS = {"stdout", "stderr"}
RAW = {"__stdout__", "__stderr__", "unescaped"}
MARKUP = {"from_markup", "from_ansi", "render_markup"}


def bypasses(tree: ast.AST, *, in_command: bool) -> Iterator[str]:
    """Yield what writes past the doors."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            names = {alias.name for alias in node.names}
            if (node.module == "rich.console" and "Console" in names) or (node.module == "rich" and "print" in names):
                yield f"{node.lineno}: rich's own console"
            if node.module == "jinja2" and "Environment" in names:
                yield f"{node.lineno}: templates that do not escape"
            if names & {"unescaped", *MARKUP}:
                yield f"{node.lineno}: {names}"
        elif isinstance(node, ast.Attribute):
            of_sys = isinstance(node.value, ast.Name) and node.value.id == "sys"
            if node.attr in RAW | MARKUP or (of_sys and node.attr in STREAMS and not in_command):
                yield f"{node.lineno}: {node.attr}"
        elif isinstance(node, ast.Call):
            name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
            of_console = isinstance(node.func, ast.Attribute) and name == "print"
            if name in PRINTS and not of_console and not in_command:
                yield f"{node.lineno}: {name}"
            if name in {"TextColumn", "Static", "Label"} and not is_plain(node):
                yield f"{node.lineno}: {name} reads markup"


def is_plain(call: ast.Call) -> bool:
    """Whether a call has the argument ``markup=False``."""
    return any(
        word.arg == "markup" and isinstance(word.value, ast.Constant) and word.value.value is False
        for word in call.keywords
    )


def test_nothing_writes_past_the_doors() -> None:
    names = {file.relative_to(ROOT).as_posix(): file for file in FILES}
    found = [
        f"{name}:{bypass}"
        for name in names.keys() - DOORS.keys()
        for bypass in bypasses(ast.parse(names[name].read_text()), in_command=name.startswith(COMMANDS))
    ]
    assert not found, "\n" + "\n".join(sorted(found))


@pytest.mark.parametrize(
    "code",
    [
        "print('a')",
        "import sys; sys.stderr.write('a')",
        "import sys; sys.__stdout__.write('a')",
        "import traceback; traceback.print_exc()",
        "from rich.console import Console",
        "from rich import print",
        "from jinja2 import Environment",
        "from rich.text import Text; Text.from_markup('a')",
        "from rich.progress import TextColumn; TextColumn('{task.description}')",
        "from graphnav.core.machine.escaped_streams import unescaped",
    ],
)
def test_a_bypass_is_found(code: str) -> None:
    assert list(bypasses(ast.parse(code), in_command=False))


def test_doors_exist() -> None:
    assert [name for name in DOORS if not (ROOT / name).is_file()] == []
