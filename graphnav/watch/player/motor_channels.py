"""Find the channels of a log that would move a robot."""

from __future__ import annotations

from graphnav.core.errors import LogError
from graphnav.core.record import Recording


def motor_channels(recording: Recording) -> dict[str, str]:
    """Return the motor channels of the graph that produced a log, each with its output.

    Empty if the log does not hold its graph.
    """
    try:
        outputs = recording.graph.get("outputs")
    except LogError:
        return {}
    found = {}
    for ref, output in outputs.items() if isinstance(outputs, dict) else ():
        if isinstance(output, dict) and output.get("motor") is True and isinstance(output.get("channel"), str):
            found[output["channel"]] = str(ref)
    return found
