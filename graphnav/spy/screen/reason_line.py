"""The line that says why there is nothing to see."""

from __future__ import annotations

from rich.text import Text
from textual.widgets import Static


class ReasonLine(Static):
    """Takes room only while there is a reason; laid out anew only where that changes, as it costs much."""

    def __init__(self) -> None:
        super().__init__(markup=False)
        self._reason = ""
        self.display = False

    def say(self, reason: str) -> None:
        """Show a reason, nothing for an empty one."""
        if reason != self._reason:
            self._reason = reason
            self.display = bool(reason)
            self.update(Text(reason))
