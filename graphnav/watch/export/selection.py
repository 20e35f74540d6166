"""Select messages of a log by channel and time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fnmatch import fnmatchcase

from graphnav import About, Recording, UserError, did_you_mean


@dataclass(frozen=True)
class Selection:
    """Channels and a time span; by default all messages except the description of the run.

    ``patterns``: channel names or shell patterns (``robot.*``). ``from_s``, ``until_s``: seconds since the beginning of
    the log, both inclusive.
    """

    patterns: tuple[str, ...] = ()
    from_s: float = -math.inf
    until_s: float = math.inf

    def channels(self, recording: Recording) -> tuple[str, ...]:
        """Return the channels, in the order of their first events.

        Raises
        ------
        UserError
            A pattern matches no channel, or the log has none.
        """
        known = recording.channels
        if not known:
            raise UserError.of(f"{recording.path} holds no messages", "name another log")
        if not self.patterns:
            return tuple(name for name in known if name != About.CHANNEL)
        for pattern in self.patterns:
            if not any(_matches(name, pattern) for name in known):
                printable = [name if name.isprintable() else ascii(name) for name in sorted(known)]
                hint = did_you_mean(pattern, printable) or f"channels are {', '.join(printable)}"
                raise UserError.of(f"{recording.path} has no channel '{pattern}'", hint)
        return tuple(name for name in known if any(_matches(name, pattern) for pattern in self.patterns))

    def one_channel(self, recording: Recording) -> str | None:
        """Return the channel if exactly one is selected by name, else None."""
        name = self.patterns[0] if len(self.patterns) == 1 else ""
        return name if name in recording.channels else None

    def holds(self, at_s: float) -> bool:
        """Whether a time, seconds since the log begins, is in the span."""
        return self.from_s <= at_s <= self.until_s

    def check_span(self, recording: Recording) -> None:
        """Raise UserError if the span is empty, or outside of the log."""
        if self.from_s > self.until_s:
            raise UserError.of(
                f"--from {self.from_s:g}s is after --until {self.until_s:g}s", "swap the two, or omit one"
            )
        end_s = duration_s(recording)
        if self.from_s > end_s:
            raise UserError.of(
                f"--from {self.from_s:g}s is after the end of the log",
                f"the log lasts {end_s:.3f} s: give a smaller value",
            )


def duration_s(recording: Recording) -> float:
    """Return the duration of a log from the first to the last event, seconds."""
    last_us = max((recording.event(name, -1).utime for name in recording.channels), default=recording.begin_us)
    return max(0.0, (last_us - recording.begin_us) / 1e6)


def _matches(name: str, pattern: str) -> bool:
    return name == pattern or fnmatchcase(name, pattern)
