"""``graphnav --help`` is quick: it loads nothing that it does not need."""

import subprocess
import sys

import pytest

from graphnav.core.cli import commands

HEAVY = {"numpy", "cv2", "lcm", "yaml", "pluggy", "rich", "sklearn", "pymunk", "matplotlib", "jinja2", "argcomplete"}


@pytest.mark.parametrize("words", [["--help"], *([command, "--help"] for command in commands())])
def test_help_loads_no_heavy_package(words: list[str]) -> None:
    code = f"""
import sys
from graphnav.core.cli import main
try:
    main({words!r})
except SystemExit as end:
    assert end.code == 0
print("loaded", sorted({HEAVY!r} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("loaded []\n")
