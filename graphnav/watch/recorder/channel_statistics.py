"""Count received and missing messages by channel."""

from __future__ import annotations

from graphnav.core.record.sequence_gaps import SequenceGaps, numbered_fingerprints, seq_of

_MAX_CHANNELS = 10_000
"""Further channels are counted together, to bound memory when a program sends random names."""


class ChannelStatistics:
    """The messages of one channel.

    ``fingerprint``: the first 8 bytes of the first message. ``gaps``: None if messages have no sequence numbers.
    """

    __slots__ = ("fingerprint", "gaps", "n_bytes", "n_messages")

    def __init__(self, fingerprint: bytes, gaps: SequenceGaps | None = None) -> None:
        self.fingerprint, self.gaps = fingerprint, gaps
        self.n_messages = self.n_bytes = 0


class ReceiveStatistics:
    """The statistics of all channels; one thread counts, others may read."""

    def __init__(self) -> None:
        self.n_messages = self.n_bytes = 0
        self.channels: dict[str, ChannelStatistics] = {}
        self.others = ChannelStatistics(b"")
        """Messages on channels beyond the first 10,000."""
        self._numbered = numbered_fingerprints()

    @property
    def lost(self) -> int:
        """The number of missing sequence numbers."""
        return sum(channel.gaps.lost for channel in list(self.channels.values()) if channel.gaps is not None)

    def receive(self, name: str, data: bytes) -> None:
        """Count a message."""
        channel = self.channels.get(name)
        if channel is None:
            channel = self._add(name, data[:8])
        size = len(data)
        channel.n_messages += 1
        channel.n_bytes += size
        self.n_messages += 1
        self.n_bytes += size
        if channel.gaps is not None and data.startswith(channel.fingerprint) and (seq := seq_of(data)) is not None:
            channel.gaps.see(seq)

    def _add(self, name: str, fingerprint: bytes) -> ChannelStatistics:
        if len(self.channels) >= _MAX_CHANNELS:
            return self.others
        gaps = SequenceGaps() if fingerprint in self._numbered else None
        channel = self.channels[name] = ChannelStatistics(fingerprint, gaps)
        return channel
