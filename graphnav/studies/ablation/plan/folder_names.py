"""Turn user-chosen names into names of folders."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Iterable

_LONGEST = 100
_OTHER = re.compile(r"[^A-Za-z0-9._+=-]+")


def folder_names(texts: Iterable[str], called: Callable[[str], str] = str) -> dict[str, str]:
    """Return a folder name for each string: portable characters, unique even where letter case is ignored.

    A name is made of the label that ``called`` returns for the string. Where strings would share a name, or it had to
    be shortened, it ends in a hash of the string.
    """
    found = {text: _slug(called(text)) for text in texts}
    times = Counter(name.casefold() for name in found.values())
    return {
        text: name if name and times[name.casefold()] == 1 and len(name) <= _LONGEST else _hashed(text, name)
        for text, name in found.items()
    }


def _slug(text: str) -> str:
    return _OTHER.sub("_", text.replace(" + ", "+").replace("/", "_")).strip("._-")


def _hashed(text: str, name: str) -> str:
    return f"{name[:_LONGEST].rstrip('._-')}-{hashlib.sha256(text.encode()).hexdigest()[:8]}".lstrip("-")
