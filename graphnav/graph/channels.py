"""Channels: one for every output port, one writer and one name each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import chain

from graphnav.errors import Problem, did_you_mean
from graphnav.graph.node import Channel
from graphnav.spec import Entry, Spec
from graphnav.stage import Stage, ports_of

MAX_NAME = 63
"""LCM's limit, characters."""
RESERVED = "graphnav."
_NAME = re.compile(r"[!-~]+")


def channels_of(spec: Spec, classes: Mapping[str, type[Stage]], problems: list[Problem]) -> dict[str, Channel]:
    """Return the channel of every output, by reference; what is wrong is added to ``problems``.

    ``classes``: the classes of the stages that are known, by stage.
    """
    channels: dict[str, Channel] = {}
    entries: dict[str, Entry] = {}
    for stage, cls in classes.items():
        for port in ports_of(cls).outputs:
            ref = f"{stage}.{port.name}"
            entry = spec.channels.get(ref)
            name = entry.value.data if entry else ref
            if entry and isinstance(name, str):
                entries[ref] = entry
            channels[ref] = Channel(ref, name if isinstance(name, str) else ref, port.message)
    for ref, entry in spec.channels.items():
        if ref not in channels and (ref.partition(".")[0] in classes or ref.partition(".")[0] not in spec.stages):
            hint = did_you_mean(ref, channels) or f"channels are {', '.join(channels)}"
            problems.append(Problem(entry.place, f"'channels' renames '{ref}', which no stage writes", hint))
    _check_names(spec, channels, entries, problems)
    return channels


def _check_names(
    spec: Spec, channels: Mapping[str, Channel], entries: Mapping[str, Entry], problems: list[Problem]
) -> None:
    writer: dict[str, str] = {}
    plain_first = chain(
        (c for c in channels.values() if c.ref not in entries), (c for c in channels.values() if c.ref in entries)
    )
    for channel in plain_first:
        entry = entries.get(channel.ref)
        place = entry.value.place if entry else spec.stages[channel.stage].place
        mend = "choose another name" if entry else f"rename it: channels: {{{channel.ref}: ...}}"
        name = channel.name
        if len(name) > MAX_NAME:
            what = f"the channel name '{name}' has {len(name)} characters, but LCM takes at most {MAX_NAME}"
            problems.append(Problem(place, what, mend))
        elif not _NAME.fullmatch(name):
            problems.append(
                Problem(place, f"{name!r} cannot be a channel's name", "use ASCII characters without spaces")
            )
        elif name.startswith(RESERVED):
            problems.append(Problem(place, f"channel names that begin with '{RESERVED}' are reserved: '{name}'", mend))
        elif name in writer:
            what = f"'{channel.ref}' and '{writer[name]}' would both write the channel '{name}'"
            problems.append(Problem(place, what, "give each its own name"))
        writer.setdefault(name, channel.ref)
