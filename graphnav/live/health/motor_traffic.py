"""What comes by on the motor channels, whoever sends it."""

from __future__ import annotations

from graphnav.motors.sender import MotorSender


class MotorTraffic:
    """Counts the messages on motor channels as a mailbox that keeps none; filled by the receiving thread."""

    def __init__(self) -> None:
        self.heard = 0
        self.motors: MotorSender | None = None

    def put(self, data: bytes, at_s: float) -> bool:
        """Count a message."""
        del data, at_s
        self.heard += 1
        return False

    def counts(self) -> tuple[int, int]:
        """Return how many messages came by and how many this run has sent."""
        heard = self.heard
        if self.motors is None:
            return 0, 0
        counts = self.motors.counts
        return heard, counts.forwarded + counts.stops
