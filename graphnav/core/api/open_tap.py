"""Open the tap of a run, for commands and the Python door."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, get_args

from graphnav.core.api.arguments import wrong_type
from graphnav.core.errors import GraphnavError
from graphnav.core.lcm_url import tap_url
from graphnav.core.tap import Tap

TapMode = Literal["thin", "full", "none"]


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


def check_tap(tap: object) -> None:
    """Raise UserError for an argument that is not a mode of the tap."""
    if tap not in get_args(TapMode):
        raise wrong_type("tap", tap, '"thin", "full" or "none"', 'write tap="thin" to watch with graphnav spy')
