"""The result of a replay."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

Kind = Literal["field", "missing", "extra"]


class FirstDifference(NamedTuple):
    """The first difference of a channel: a field of a message, or a message that only one side has.

    ``at_us``: microseconds of the run. ``where``: the index in an array.
    """

    at_us: int
    kind: Kind
    field: str = ""
    where: tuple[int, ...] = ()
    recorded: Any = None
    replayed: Any = None


@dataclass
class FieldResult:
    """A field that differs: the number of messages, the maximum difference, and the first one.

    ``max_gap``: None unless both values are numbers, infinity if one of them is not finite.
    """

    first: FirstDifference
    n_messages: int = 0
    max_gap: float | None = None


@dataclass
class ChannelResult:
    """The result for the messages of a channel."""

    n_compared: int = 0
    n_differing: int = 0
    n_missing: int = 0
    """Recorded messages that the replay did not publish."""
    n_extra: int = 0
    """Messages that only the replay published."""
    n_not_recorded: int = 0
    """Published messages that cannot be compared: the log is damaged, or keeps only small messages of the channel."""
    first: FirstDifference | None = None
    fields: dict[str, FieldResult] = field(default_factory=dict)

    @property
    def is_equal(self) -> bool:
        """Whether there are no differences."""
        return self.first is None

    @property
    def max_gap(self) -> float | None:
        """The maximum difference of numbers, None without one."""
        return max((one.max_gap for one in self.fields.values() if one.max_gap is not None), default=None)


class Reproduced(NamedTuple):
    """A source that was stepped again, with the recorded messages of ``inputs``, to make ``channels`` again.

    ``checked``: its other channels, which are in the log and were compared.
    """

    stage: str
    channels: tuple[str, ...]
    inputs: tuple[str, ...]
    checked: tuple[str, ...]


@dataclass(frozen=True)
class ReplayResult:
    """The replayed part of a log, and the comparison with the recorded messages."""

    log: str
    from_s: float
    """The start of the comparison."""
    until_s: float
    """The timestamp of the last tick."""
    n_ticks: int
    """The number of firings for a live run."""
    is_live: bool
    """Whether the run was live."""
    wall_s: float
    stepped: tuple[str, ...]
    played: tuple[str, ...]
    not_needed: tuple[str, ...]
    reproduced: tuple[Reproduced, ...]
    """Sources that made again what the log leaves out."""
    channels: dict[str, ChannelResult]
    """The results by channel, in firing order."""
    new: Mapping[str, int]
    """The number of messages on each channel that the run did not have; they are not compared."""
    not_replayed: tuple[str, ...]
    """Channels of the log on which the replay does not publish."""
    lost: tuple[str, ...]
    """Damage of the log, and its consequences."""
    failure: str
    """Why the replay ended early, empty if it did not."""
    scores: Mapping[str, Mapping[str, float]]
    recorded_scores: Mapping[str, Mapping[str, float]]
    """Metrics by stage, of the replay and of the recorded run if its folder has a summary."""

    @property
    def is_equal(self) -> bool:
        """Whether all compared messages are equal."""
        return not self.failure and all(channel.is_equal for channel in self.channels.values())

    @property
    def unlike(self) -> tuple[tuple[Reproduced, tuple[str, ...]], ...]:
        """The sources that made again what differs from the log, and the channels on which it does."""
        found = (
            (one, tuple(name for name in one.checked if name in self.channels and not self.channels[name].is_equal))
            for one in self.reproduced
        )
        return tuple((one, names) for one, names in found if names)

    @property
    def first(self) -> tuple[str, FirstDifference] | None:
        """The first channel that differs, by time and then by firing order, and its first difference."""
        found = [(name, channel.first) for name, channel in self.channels.items() if channel.first is not None]
        return min(found, key=lambda one: one[1].at_us, default=None)

    def as_json(self) -> dict[str, Any]:
        """Return the result as JSON-compatible values; non-finite numbers become null."""
        first = self.first
        return {
            "log": self.log,
            "equal": self.is_equal,
            "first": {"channel": first[0], **_first_as_json(first[1])} if first else None,
            "from_s": self.from_s,
            "until_s": self.until_s,
            "live": self.is_live,
            "ticks": self.n_ticks,
            "wall_s": round(self.wall_s, 4),
            "stepped": list(self.stepped),
            "played": list(self.played),
            "not_needed": list(self.not_needed),
            "reproduced": [one._asdict() for one in self.reproduced],
            "new": dict(self.new),
            "not_replayed": list(self.not_replayed),
            "channels": {name: _channel_as_json(channel) for name, channel in self.channels.items()},
            "scores": {stage: _finite(metrics) for stage, metrics in self.scores.items()},
            "recorded_scores": {stage: _finite(metrics) for stage, metrics in self.recorded_scores.items()},
            "lost": list(self.lost),
            "failure": self.failure,
        }


def _channel_as_json(channel: ChannelResult) -> dict[str, Any]:
    return {
        "equal": channel.is_equal,
        "compared": channel.n_compared,
        "differing": channel.n_differing,
        "missing": channel.n_missing,
        "extra": channel.n_extra,
        "not_recorded": channel.n_not_recorded,
        "first": _first_as_json(channel.first) if channel.first else None,
        "fields": {
            name: {
                "differing": one.n_messages,
                "max_abs": _number(one.max_gap),
                "first": _first_as_json(one.first),
            }
            for name, one in channel.fields.items()
        },
    }


def _first_as_json(first: FirstDifference) -> dict[str, Any]:
    where = {"at_s": first.at_us / 1e6, "kind": first.kind}
    if first.kind != "field":
        return where
    values = {"recorded": _number(first.recorded), "replayed": _number(first.replayed)}
    return {**where, "field": first.field, "index": list(first.where), **values}


def _finite(metrics: Mapping[str, float]) -> dict[str, Any]:
    return {name: _number(value) for name, value in metrics.items()}


def _number(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, int | float | str | None) else repr(value)
