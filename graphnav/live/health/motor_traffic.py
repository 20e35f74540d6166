"""Watch the motor channels: whether what this run sends is sent on, and who else sends."""

from __future__ import annotations

from collections.abc import Iterator

from graphnav.live.motors.counts import Counts
from graphnav.live.motors.sender import MotorSender

_FAILING_S = 1.0


class MotorTraffic:
    """A mailbox that counts messages on the motor channels without keeping them; filled by the receive thread.

    `look` is called at every turn of the runner: it notices within a turn that the motor process takes no commands.
    ``substituted``: stops that this process has sent in place of the motor process.
    """

    def __init__(self) -> None:
        self.heard = 0
        self.substituted = self._substituted = 0
        self.motors: MotorSender | None = None
        self.fault = ""
        """Why the motor channels get nothing, empty if they do."""
        self._unread_s = 0.0
        self._counts = Counts()
        self._failed_s = -_FAILING_S

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
        return heard, counts.forwarded + counts.stops + self.substituted

    @property
    def late(self) -> int:
        """Number of commands that the motor process did not send because they were older than ``max_age_s``."""
        return self.motors.counts.late if self.motors is not None else 0

    @property
    def is_substituted(self) -> bool:
        """Whether the motor process takes no commands, and this process sends stops in its place."""
        return bool(self._unread_s) and self.substituted > self._substituted

    def look(self, now_s: float) -> Iterator[str]:
        """Update `fault`, and yield what has begun or ended since the last call; ``now_s``: monotonic."""
        if self.motors is None:
            return
        before_s, self._unread_s = self._unread_s, self.motors.unread_s(now_s)
        counts, last = self.motors.counts, self._counts
        self._counts = counts
        if counts.failed > last.failed:
            if now_s - self._failed_s >= _FAILING_S:
                yield "motors: the network takes no messages on the motor channels: nothing is sent"
            self._failed_s = now_s
        is_failing = now_s - self._failed_s < _FAILING_S
        self.fault = "the network takes no messages: nothing is sent" if is_failing else ""
        if self._unread_s:
            sent = "only stops are sent, by the run" if self.is_substituted else "nothing is sent"
            self.fault = f"not taken for {self._unread_s:.1f} s: {sent}"
            if not before_s:
                yield (
                    f"motors: the process that sends the motor channels (pid {self.motors.pid}) has not taken commands "
                    f"for {self._unread_s:.2f} s: nothing is sent"
                )
            return
        self._substituted = self.substituted
        if before_s:
            yield f"motors: commands are taken again, after {before_s:.2f} s"
