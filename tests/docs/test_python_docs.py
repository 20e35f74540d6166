"""``docs/howto/python.md``: its blocks run in order, and it names every function of the door."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "howto" / "python.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", DOCUMENT.read_text(), re.DOTALL | re.MULTILINE)


def test_the_blocks_run_one_after_another(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text("".join(BLOCKS))
    work = tmp_path / "work"
    work.mkdir()
    command = [sys.executable, "-W", "error", str(script)]
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert re.sub(r".* does not hold its large messages: .*\n", "", done.stderr) == ""
    assert "did you mean 'affine'?" in done.stdout
    assert list(work.iterdir()) == []


def test_every_function_is_in_the_table() -> None:
    told = set(re.findall(r"^\| `graphnav\.(\w+)\(", DOCUMENT.read_text(), re.MULTILINE))
    assert told == {
        "ablate",
        "calibrate",
        "check",
        "draw",
        "load",
        "make_env",
        "make_vec_env",
        "open_log",
        "profile",
        "run",
    }
