"""Which channels to take."""

from __future__ import annotations

import re
from collections.abc import Iterable
from fnmatch import translate
from functools import lru_cache

from graphnav.errors import Place, UserError

_MAX_REMEMBERED = 4096


class ChannelFilter:
    """Takes a channel whose name matches any of some patterns; all channels if there are none.

    ``globs``: as in a shell, ``robot.*``. ``regexes``: as LCM subscribes, matched against the entire name. ``invert``
    takes what does not match instead.

    Raises
    ------
    UserError
        A pattern is not a regular expression.
    """

    def __init__(self, globs: Iterable[str] = (), regexes: Iterable[str] = (), *, invert: bool = False) -> None:
        globs, regexes = list(globs), list(regexes)
        self.patterns = [*globs, *regexes]
        """As they were given."""
        self._patterns = [re.compile(translate(glob), re.DOTALL) for glob in globs]
        self._patterns += [_compiled(regex) for regex in regexes]
        self._invert = invert
        self.takes = lru_cache(_MAX_REMEMBERED)(self._takes)
        """Whether a channel is taken, by its name."""

    def _takes(self, channel: str) -> bool:
        if not self._patterns:
            return True
        return self._invert != any(pattern.fullmatch(channel) for pattern in self._patterns)


def _compiled(regex: str) -> re.Pattern[str]:
    try:
        return re.compile(regex)
    except re.error as error:
        what = f"'{regex}' is not a regular expression: {error}"
        raise UserError.of(what, "escape special characters with a backslash", Place("--regex")) from error
