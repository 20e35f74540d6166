"""A graph whose rivals have known best parameters."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

GRAPH = """\
run: {until_s: 5}
stages:
  clock: {use: aim.clock}
  aim:   {use: aim.near, in: {twist: clock}}
  score: {use: aim.miss, in: {twist: aim.twist}}
"""


@pytest.fixture
def aim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the arguments of a tuning of two rivals."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "aim.yaml").write_text(GRAPH)
    shutil.copy(Path(__file__).with_name("aiming_stages.py"), tmp_path / "my_aims.py")
    return {
        "study": "aim",
        "vary": {"aim": ["aim.near", "aim.fixed"]},
        "plugins": ["my_aims.py"],
        "seeds": range(3),
        "metrics": ["score.hit", "score.miss_m"],
        "trials": 12,
        "jobs": 1,
    }


WORDS = [
    "tune", "aim", "--vary", "aim=aim.near,aim.fixed", "--plugin", "my_aims.py",
    "--seeds", "0:3", "--metrics", "score.hit,score.miss_m",
]  # fmt: skip
"""The same on the command line, without the number of trials."""
