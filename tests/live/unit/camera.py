"""A sender of messages, its edge and our two clocks, all simulated."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from graphnav.live.inputs.sender_monitor import SenderMonitor, Verdict

EPOCH_US = 1_760_000_000_000_000


@dataclass
class Camera:
    """Sends to a monitor: stamps of its clock, arrivals of ours, seconds since the start."""

    monitor: SenderMonitor
    rate_hz: float = 20.0
    jitter_s: float = 0.0
    offset_s: float = 0.0
    """Its clock less ours."""
    drift_ratio: float = 0.0
    is_counting: bool = True
    writers: tuple[str, ...] = ()
    seq: int = 0
    frame: int = 0
    arrival_s: float = 0.0
    verdicts: list[Verdict] = field(default_factory=list)
    noise: random.Random = field(default_factory=lambda: random.Random(7))

    def send(self, count: int = 1, delay_s: float = 0.0) -> list[Verdict]:
        """Send frames, each of which takes ``delay_s`` and never overtakes another one; return their verdicts."""
        for _ in range(count):
            sent_s = self.frame / self.rate_hz + self.noise.uniform(0, self.jitter_s)
            self.arrival_s = max(self.arrival_s + 1e-5, sent_s + delay_s)
            self.verdicts.append(self.deliver(sent_s + self.offset_s + self.drift_ratio * sent_s))
            self.frame += 1
            self.seq += 1
        return self.verdicts[-count:]

    def deliver(self, stamp_s: float) -> Verdict:
        """Let a message with this stamp arrive now."""
        return self.monitor.judge(
            self.arrival_s,
            EPOCH_US + round(self.arrival_s * 1e6),
            EPOCH_US + round(stamp_s * 1e6),
            self.seq if self.is_counting else None,
            self.writers,
            self.writers[0] if len(self.writers) == 1 else "",
        )

    def pause(self, duration_s: float) -> None:
        """Send nothing for so long."""
        self.frame += round(duration_s * self.rate_hz)


def reasons(verdicts: list[Verdict]) -> list[str]:
    """Return why each message was rejected, empty for those that were not."""
    return [verdict.reason for verdict in verdicts]
