"""``python -m graphnav`` is the command ``graphnav``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

MODULE = [sys.executable, "-m", "graphnav"]
COMMAND = Path(sys.executable).with_name("graphnav")


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["run", "--help"], ["run", "nowhere"], []])
def test_the_module_is_the_command(words: list[str], tmp_path: Path) -> None:
    if not COMMAND.exists():
        pytest.skip("the command 'graphnav' is not beside this Python: pip install -e .")
    module, command = (
        subprocess.run([*program, *words], cwd=tmp_path, capture_output=True, text=True, check=False)
        for program in (MODULE, [str(COMMAND)])
    )
    assert (module.returncode, module.stdout, module.stderr) == (command.returncode, command.stdout, command.stderr)
    assert "__main__" not in module.stdout + module.stderr
