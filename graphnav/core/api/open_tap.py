"""Open the tap of a run, for commands and the Python door."""

from __future__ import annotations

from collections.abc import Callable

from graphnav.core.api.parameters import TapMode
from graphnav.core.errors import GraphnavError
from graphnav.core.lcm_url import tap_url
from graphnav.core.tap import Tap


def open_tap(
    mode: TapMode, run_id: str, *, tell: Callable[[str], None], notice: Callable[[str], None] | None = None
) -> Tap | None:
    """Return the tap, or None if it is off or there is no multicast.

    ``tell`` gets the reason if there is none; ``notice``, by default the same, gets notices of other runs on its group.
    """
    if mode == "none":
        return None
    try:
        return Tap(mode, run_id, tap_url(), notice or tell)
    except GraphnavError as error:
        tell(f"no tap: {error}")
        return None
