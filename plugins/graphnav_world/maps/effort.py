"""How much computing the draws of a map may take."""

from __future__ import annotations

MAX_STEPS = 16_000_000
"""Of all draws of a map from one seed; some 50 ns each, which is under a second."""


class Effort:
    """Counts the steps of computing that the draws of a map take.

    Counted and not timed, so that every machine, however busy, draws the same map or refuses the same one.
    """

    def __init__(self, max_steps: int = MAX_STEPS) -> None:
        self._left = max_steps

    @property
    def is_spent(self) -> bool:
        """Whether no step is left."""
        return self._left <= 0

    def spend(self, steps: int) -> None:
        """Count so many steps."""
        self._left -= steps
