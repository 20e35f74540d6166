"""A motor channel: its name, its stop and how long it may be silent."""

from __future__ import annotations

from dataclasses import dataclass

INT64_BYTES = 8


@dataclass(frozen=True)
class MotorTopic:
    """A ROS 2 topic as the sending process needs it: its type by name and definition, and where ROS programs are."""

    type_name: str
    definition: str
    domain: int
    interface: str


@dataclass(frozen=True)
class MotorChannel:
    """An LCM channel or a ROS 2 topic that moves a robot, as the sending process needs it.

    ``stop`` is an encoded message that stops the robot. ``stamp_at`` and ``seq_at`` are the byte offsets, in the stop
    and in every command, of a big-endian int64 stamp (microseconds) and an int64 sequence number; None where
    the type has none. Silence longer than ``max_age_s`` (seconds) causes stops. Of a ``topic`` the stamp is that of the
    header: int32 seconds and uint32 nanoseconds, little-endian.

    Raises ValueError if ``max_age_s`` is not positive and finite, or an offset lies outside of ``stop``.
    """

    name: str
    stop: bytes
    stamp_at: int | None
    seq_at: int | None
    max_age_s: float
    topic: MotorTopic | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.max_age_s < float("inf"):
            raise ValueError(f"motor channel '{self.name}': max_age_s is {self.max_age_s}, expected seconds above 0")
        for name, at in (("stamp_at", self.stamp_at), ("seq_at", self.seq_at)):
            if at is not None and not 0 <= at <= len(self.stop) - INT64_BYTES:
                raise ValueError(f"motor channel '{self.name}': {name} is {at}, the stop has {len(self.stop)} bytes")
