"""Printer of what slow tests measure, beside its targets."""

from __future__ import annotations

from collections.abc import Callable


class Targets:
    """Prints what a test measures as soon as it is known; a figure that misses its target fails the test at its end."""

    def __init__(self, show: Callable[[str], None]) -> None:
        self.missed: list[str] = []
        self._show = show

    def say(self, text: str) -> None:
        """Print a figure that has no target."""
        self._show(f"     {text}")

    def check(self, text: str, *, good: bool) -> None:
        """Print a figure and whether it meets its target."""
        self._show(f"{'ok  ' if good else 'MISS'} {text}")
        if not good:
            self.missed.append(text)
