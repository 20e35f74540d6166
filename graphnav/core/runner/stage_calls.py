"""The call into a stage that is in progress, as another thread sees it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

Call = tuple[str, str, int, Mapping[str, Any], float]
"""The stage, the method, the stamp (microseconds), the inputs by port, and when it began (monotonic seconds)."""

_HELD_S = 0.01


class StageCalls:
    """Notes every call into a stage of a run; ``mark`` gets stage, method and stamp before the call."""

    def __init__(self, mark: Callable[[str, str, int], None] | None = None) -> None:
        self.current: Call | None = None
        """The call in progress, None between two calls."""
        self._mark = mark
        self._is_held = False

    def begin(self, stage: str, method: str, utime: int, inputs: Mapping[str, Any]) -> None:
        """Note that a call begins."""
        if self._mark is not None:
            self._mark(stage, method, utime)
        self.current = stage, method, utime, inputs, time.monotonic()

    def end(self) -> None:
        """Note that the call has ended; does not return while another thread ends the run."""
        self.current = None
        while self._is_held:
            time.sleep(_HELD_S)

    def wait_for(self, call: Call | None) -> None:
        """Note the call that this thread waits for while it does other things; does not return as `end` does not."""
        self.current = call
        while self._is_held:
            time.sleep(_HELD_S)

    def hold(self, call: Call) -> bool:
        """Let ``call`` not return into the run any more; return False if it has done so already.

        For the thread that ends a run whose stage hangs: from here on it alone writes the log.
        """
        self._is_held = True
        if self.current is call:
            return True
        self._is_held = False
        return False
