"""Merge two mappings of graphs, every value with its own place."""

from __future__ import annotations

from graphnav.core.errors import Problem, did_you_mean
from graphnav.core.spec import Entry, Value


def merge_entries(old: Entry, new: Entry, who: str, problems: list[Problem], *, null_removes: bool) -> Entry:
    """Return what is under one key when ``new`` overrides ``old``; ``who`` is what errors call it.

    Mappings are merged key by key, and nothing under a key changes nothing. With ``null_removes`` null removes a key
    and mappings in it are merged too; without it null is a value, and every value replaces the old one. What is not a
    mapping is replaced. A key that cannot be removed is added to ``problems``.
    """
    if new.value.data is None:
        return old
    if not isinstance(old.value.data, dict) or not isinstance(new.value.data, dict):
        return new
    words = dict(old.value.data)
    for key, entry in new.value.data.items():
        before = words.get(key)
        if not null_removes or (entry.value.data is not None and before is None):
            words[key] = entry
        elif entry.value.data is not None and before is not None:
            words[key] = merge_entries(before, entry, f"'{key}' of {who}", problems, null_removes=True)
        elif before is not None:
            del words[key]
        else:
            problems.append(nothing_to_remove(f"{who} of the extended graph", key, entry, old.value.data))
    return Entry(new.place, Value(words, new.value.place))


def nothing_to_remove(who: str, key: str, entry: Entry, known: dict[str, Entry]) -> Problem:
    """Return the problem of a null whose key the extended graph does not have."""
    hint = did_you_mean(key, known) or (f"it has {', '.join(known)}" if known else "it has none")
    return Problem(entry.place, f"null removes '{key}', but {who} has no such key", hint)
