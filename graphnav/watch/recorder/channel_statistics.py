"""The accounts of all recorded channels."""

from __future__ import annotations

from graphnav.core.record import ChannelCounts, Kind, kind_of

_MAX_CHANNELS = 10_000
"""Further channels are counted together, to bound memory when a program sends random names."""


class RecordedChannel(ChannelCounts):
    """The counts of one channel.

    ``fingerprint``: the first 8 bytes of the first message. ``kind``: its type, None if it is not known.
    """

    __slots__ = ("fingerprint", "kind")

    def __init__(self, fingerprint: bytes = b"", kind: Kind | None = None) -> None:
        super().__init__()
        self.fingerprint, self.kind = fingerprint, kind

    @property
    def lost(self) -> int | None:
        """The number of missing sequence numbers, None if messages have none."""
        return self.gaps.lost if self.kind is not None and self.kind.is_stamped else None


class ReceiveStatistics:
    """The counts of all channels; one thread counts, others may read."""

    def __init__(self) -> None:
        self.n_messages = self.n_bytes = 0
        self.channels: dict[str, RecordedChannel] = {}
        self.others = RecordedChannel()
        """Messages on channels beyond the first 10,000."""

    @property
    def lost(self) -> int:
        """The number of missing sequence numbers."""
        return sum(channel.lost or 0 for channel in list(self.channels.values()))

    def receive(self, name: str, data: bytes, at_s: float) -> None:
        """Count a message."""
        channel = self.channels.get(name)
        if channel is None:
            channel = self._add(name, data)
        channel.add(len(data), at_s)
        self.n_messages += 1
        self.n_bytes += len(data)
        kind = channel.kind
        if kind is not None and kind.is_stamped and data.startswith(channel.fingerprint):
            stamp = kind.stamp(data)
            if stamp is not None:
                channel.gaps.see(stamp[1])

    def _add(self, name: str, data: bytes) -> RecordedChannel:
        if len(self.channels) >= _MAX_CHANNELS:
            return self.others
        channel = self.channels[name] = RecordedChannel(data[:8], kind_of(data))
        return channel
