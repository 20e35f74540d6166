"""A line that explains why a view is empty."""

from __future__ import annotations

from rich.text import Text
from textual.widgets import Static


class ReasonLine(Static):
    """Takes space only while there is a reason; layout changes, which are expensive, only then."""

    def __init__(self) -> None:
        super().__init__(markup=False)
        self._reason = ""
        self.display = False

    def say(self, reason: str) -> None:
        """Show a reason; an empty one hides the line."""
        if reason != self._reason:
            self._reason = reason
            self.display = bool(reason)
            self.update(Text(reason))
