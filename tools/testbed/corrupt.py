"""Corrupt messages in transit, as a broken sender or edge would."""

from __future__ import annotations

import graphnav_lcm

_STAMP = slice(8, 16)
_BACK_US = 20_000

WRONG_TYPE, TRUNCATED, WRONG_SIZE, NAN = "wrong type", "truncated", "wrong size", "NaN"
REPEATED, BACKWARDS = "stamps repeat", "stamps run backwards"
KINDS = {
    "CAMERA": (WRONG_TYPE, TRUNCATED, WRONG_SIZE, REPEATED, BACKWARDS),
    "ODOMETRY": (WRONG_TYPE, TRUNCATED, NAN, REPEATED, BACKWARDS),
    "TELEOP": (WRONG_TYPE, TRUNCATED, NAN, REPEATED, BACKWARDS),
    "STOP": (WRONG_TYPE, TRUNCATED),
}
"""Kinds of corruption by channel; the sender and the stamps of a stop do not matter."""
CLASSES = {
    "CAMERA": graphnav_lcm.image_t,
    "ODOMETRY": graphnav_lcm.odometry_t,
    "TELEOP": graphnav_lcm.twist_t,
    "STOP": graphnav_lcm.stop_t,
}


class Corrupter:
    """Corrupts every second message of a channel.

    Stamps repeat that of the message before, or run backwards from that of the first.
    """

    def __init__(self, channel: str) -> None:
        self._channel = channel
        self._count = 0
        self._kind = ""
        self._stamp = 0
        self._last = b""

    def spoil(self, kind: str, data: bytes) -> bytes:
        """Return a message, corrupted or unchanged."""
        if kind != self._kind:
            self._kind, self._stamp, self._count = kind, int.from_bytes(data[_STAMP], "big"), 0
        self._count += 1
        if self._count % 2:
            self._last = data[_STAMP]
            return data
        return self._spoiled(kind, data)

    def _spoiled(self, kind: str, data: bytes) -> bytes:
        if kind == TRUNCATED:
            return data[:-3]
        if kind == WRONG_TYPE:
            return bytes(graphnav_lcm.goal_t().encode())
        if kind == REPEATED:
            return data[:8] + self._last + data[16:]
        if kind == BACKWARDS:
            self._stamp -= _BACK_US
            return data[:8] + self._stamp.to_bytes(8, "big") + data[16:]
        message = CLASSES[self._channel].decode(data)
        if kind == NAN:
            message.v_mps = float("nan")
        else:
            message.rows, message.size = message.rows // 2, message.size // 2
            message.data = message.data[: message.size]
        return bytes(message.encode())
