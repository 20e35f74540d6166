"""Channels that are chosen by regular expressions, each with a rate."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

from graphnav.core.cli import positive

_MAX_PATTERNS, _MAX_PATTERN = 100, 200
_MAX_REMEMBERED = 4096
_LIMITED = re.compile(r"(.+)@([0-9.eE+-]+)", re.DOTALL)


class Chosen(NamedTuple):
    """A regular expression for names of channels, and the rate that it limits them to; infinite for none."""

    pattern: str
    limit_hz: float = math.inf


def chosen(text: str) -> Chosen:
    """Parse ``REGEX`` or ``REGEX@HZ``."""
    found = _LIMITED.fullmatch(text)
    one = Chosen(found[1], positive(found[2])) if found else Chosen(text)
    if len(one.pattern) > _MAX_PATTERN:
        raise argparse.ArgumentTypeError(
            f"a regular expression of {len(one.pattern)} characters, at most {_MAX_PATTERN}"
        )
    try:
        re.compile(one.pattern)
    except (re.error, OverflowError, RecursionError) as error:
        raise argparse.ArgumentTypeError(
            f"'{one.pattern}' is not a regular expression: {error}; escape special characters with a backslash"
        ) from error
    return one


class Choice:
    """A choice of channels: of several patterns that match the entire name of a channel the first one counts."""

    def __init__(self, patterns: Sequence[Chosen]) -> None:
        self._patterns = tuple(patterns)
        self._compiled = [(re.compile(one.pattern), one.limit_hz) for one in patterns]
        self._names = {one.pattern for one in patterns}
        self._known: dict[str, float | None] = {}

    @classmethod
    def told(cls, data: Any) -> Self:
        """Return the choice that the other end told; raises ValueError for anything else."""
        if not isinstance(data, list) or len(data) > _MAX_PATTERNS:
            raise ValueError(f"something else than a choice of at most {_MAX_PATTERNS} channels")
        patterns = []
        for one in data:
            match one:
                case [str(pattern), int() | float() | None as limit_hz] if len(pattern) <= _MAX_PATTERN:
                    limit_hz = math.inf if limit_hz is None else float(limit_hz)
                    if not limit_hz > 0:
                        raise ValueError("a rate that is not above 0")
                    patterns.append(Chosen(pattern, limit_hz))
                case _:
                    raise ValueError("something else than a pattern with its rate")
        try:
            return cls(patterns)
        except (re.error, OverflowError, RecursionError) as error:
            raise ValueError("something else than a regular expression") from error

    @property
    def as_told(self) -> list[tuple[str, float | None]]:
        """The patterns and their rates, for `told`."""
        return [(one.pattern, one.limit_hz if math.isfinite(one.limit_hz) else None) for one in self._patterns]

    def limit_hz(self, channel: str) -> float | None:
        """Return the rate that a channel is limited to, infinite for none; None if it is not chosen."""
        if channel not in self._known:
            if len(self._known) >= _MAX_REMEMBERED:
                self._known.clear()
            limits = (limit_hz for pattern, limit_hz in self._compiled if pattern.fullmatch(channel))
            self._known[channel] = next(limits, None)
        return self._known[channel]

    def names(self, channel: str) -> bool:
        """Whether a pattern is the name of a channel, and not one of many that it matches."""
        return channel in self._names or re.escape(channel) in self._names
