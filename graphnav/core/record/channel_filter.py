"""Select channels by name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from fnmatch import translate
from functools import lru_cache

from graphnav.core.errors import Place, UserError

_MAX_REMEMBERED = 4096


class ChannelFilter:
    """Accepts channels whose names match any of the patterns; all channels if there are no patterns.

    ``globs``: shell patterns, ``robot.*``. ``regexes``: as in LCM subscriptions, matched against the entire name.
    ``invert`` accepts the channels that do not match.

    Raises
    ------
    UserError
        A pattern is not a valid regular expression.
    """

    def __init__(self, globs: Iterable[str] = (), regexes: Iterable[str] = (), *, invert: bool = False) -> None:
        globs, regexes = list(globs), list(regexes)
        self.patterns = [*globs, *regexes]
        """The patterns as given."""
        self._patterns = [re.compile(translate(glob), re.DOTALL) for glob in globs]
        self._patterns += [_compiled(regex) for regex in regexes]
        self._invert = invert
        self._without: frozenset[str] = frozenset()
        self.takes = lru_cache(_MAX_REMEMBERED)(self._takes)
        """Whether a channel is accepted, by its name."""

    def without(self, channels: Iterable[str]) -> ChannelFilter:
        """Return this filter, which no longer accepts some channels."""
        self._without |= frozenset(channels)
        self.takes.cache_clear()
        return self

    def _takes(self, channel: str) -> bool:
        if channel in self._without:
            return False
        if not self._patterns:
            return True
        return self._invert != any(pattern.fullmatch(channel) for pattern in self._patterns)


def _compiled(regex: str) -> re.Pattern[str]:
    try:
        return re.compile(regex)
    except re.error as error:
        what = f"'{regex}' is not a regular expression: {error}"
        raise UserError.of(what, "escape special characters with a backslash", Place("--regex")) from error
