"""Open a log with what it leaves out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.record import Recording
from graphnav.core.rooms import MissingRoomError, in_room


def open_completed(
    path: Path,
    catalog: Catalog | None = None,
    plugins: Sequence[Path] = (),
    *,
    channels: Collection[str] | None = None,
    tell: Callable[[str], None] = lambda _: None,
    on_tick: Callable[[int], None] = lambda _: None,
) -> Recording:
    """Open a log; if it leaves out messages that a replay makes again, with them, as the run had published them.

    ``channels``: those that are read, None for all; nothing is made if the log has every message of them. ``tell`` gets
    one notice: that messages were made again, or why they cannot be. Then the log is opened as it is. The messages that
    the log does hold must come out equal. ``catalog``, ``plugins``: as for `graph_to_replay`; the trust of the catalog
    decides whether plugins of the run folder run. ``on_tick`` gets the time of the replayed run, microseconds.

    Raises
    ------
    LogError
        The file cannot be read or is not a log.
    """
    recording = Recording(path)
    wanted = recording.channels if channels is None else channels
    if not recording.leaves_out or not any(recording.lacks(channel) for channel in wanted):
        return recording
    lacking = f"{path} does not hold its large messages"
    try:
        made = in_room("replay.completed_log").complete(recording, catalog or Catalog(), plugins, on_tick)
    except MissingRoomError as error:
        tell(f"{lacking}: {error}")
        return recording
    if made.content is None:
        tell(f"{lacking}, and they cannot be recomputed: {made.why}\n  only what it holds is shown; {made.hint}")
        return recording
    how = (
        f"a replay recomputed them in {made.wall_s:.1f} s"
        if made.wall_s
        else "an earlier replay kept them in the cache"
    )
    tell(f"{lacking}: {how}")
    completed = Recording(path, made.content)
    completed.truncated, completed.damaged = recording.truncated, recording.damaged
    recording.close()
    return completed
