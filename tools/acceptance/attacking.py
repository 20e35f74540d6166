"""Acceptance test: the long attack."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

_ATTACK = Path(__file__).resolve().parents[1] / "attack.py"


def attack_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Run the long attack, which prints what was tried and what did harm; it takes some two hours and needs root."""
    return subprocess.run([sys.executable, str(_ATTACK), "--long"], check=False).returncode == 0
