"""Count the messages on the motor channels from all senders."""

from __future__ import annotations

from graphnav.motors.sender import MotorSender


class MotorTraffic:
    """A mailbox that counts messages on the motor channels without keeping them; filled by the receive thread."""

    def __init__(self) -> None:
        self.heard = 0
        self.motors: MotorSender | None = None

    def put(self, data: bytes, at_s: float) -> bool:
        """Count a message."""
        del data, at_s
        self.heard += 1
        return False

    def counts(self) -> tuple[int, int]:
        """Return the number of messages seen, and how many of them this run has sent."""
        heard = self.heard
        if self.motors is None:
            return 0, 0
        counts = self.motors.counts
        return heard, counts.forwarded + counts.stops
