"""Signs of constant errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def drawn_sign(seed: Sequence[int]) -> float:
    """Return -1 or 1, each with probability one half."""
    return 1.0 if np.random.default_rng(seed).integers(2) else -1.0
