"""Channels of a graph: their names, also those of inputs and outputs, with one writer each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import chain

from graphnav.core.errors import Place, Problem, did_you_mean
from graphnav.core.graph.node import Channel, InputChannel, OutputChannel
from graphnav.core.ros2 import why_not_a_topic
from graphnav.core.spec import Entry, Spec
from graphnav.core.stage import Stage, ports_of

MAX_NAME = 63
"""LCM's limit, characters."""
RESERVED = "graphnav."
_NAME = re.compile(r"[!-~]+")


def channels_of(
    spec: Spec, classes: Mapping[str, type[Stage]], inputs: Mapping[str, Channel], problems: list[Problem]
) -> dict[str, Channel]:
    """Return every channel by reference, ``inputs`` first; what is wrong is added to ``problems``.

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
            hint = f"write its channel under inputs: {{{ref}: ...}}" if ref in spec.inputs else hint
            problems.append(Problem(entry.place, f"'channels' renames '{ref}', which no stage writes", hint))
    channels = {**inputs, **channels}
    _check_names(spec, channels, entries, problems)
    return channels


def why_not_a_name(name: str) -> tuple[str, str] | None:
    """Return why LCM or graphnav refuses a channel's name, and a hint or nothing; None if it is fine."""
    if len(name) > MAX_NAME:
        return f"the channel name '{name}' has {len(name)} characters, but LCM takes at most {MAX_NAME}", ""
    if not _NAME.fullmatch(name):
        return f"{name!r} cannot be a channel's name", "use ASCII characters without spaces"
    if name.startswith(RESERVED):
        return f"channel names that begin with '{RESERVED}' are reserved: '{name}'", ""
    return None


def _check_names(
    spec: Spec, channels: Mapping[str, Channel], entries: Mapping[str, Entry], problems: list[Problem]
) -> None:
    writer: dict[str, str] = {}
    plain_first = chain(
        (c for c in channels.values() if c.ref not in entries), (c for c in channels.values() if c.ref in entries)
    )
    for channel in plain_first:
        entry = entries.get(channel.ref)
        place, fix = _place(spec, channel, entry)
        name = channel.name
        if reason := why_not_a_name(name):
            problems.append(Problem(place, reason[0], reason[1] or fix))
        elif name in writer:
            what = f"'{channel.ref}' and '{writer[name]}' would both write the channel '{name}'"
            problems.append(Problem(place, what, "give each its own name"))
        writer.setdefault(name, channel.ref)


def _place(spec: Spec, channel: Channel, entry: Entry | None) -> tuple[Place, str]:
    """Return where a channel gets its name, and how to give it another."""
    if entry is not None:
        return entry.value.place, "choose another name"
    if channel.ref in spec.inputs:
        return spec.inputs[channel.ref].place, "choose another name"
    return spec.stages[channel.stage].place, f"rename it: channels: {{{channel.ref}: ...}}"


def check_outside_names(
    spec: Spec,
    channels: Mapping[str, Channel],
    inputs: Mapping[str, InputChannel],
    outputs: Mapping[str, OutputChannel],
    problems: list[Problem],
) -> None:
    """Add what is wrong with the names under which channels come in and leave.

    ``channels``: all of the graph; what is watched on the network has their names, so that others may not use them.
    """
    users = {channel.name: f"stage '{channel.stage}' writes" for ref, channel in channels.items() if ref not in inputs}
    for ref, found in inputs.items():
        _check_topic(f"the input '{ref}'", spec.inputs[ref].ros2, problems)
        entry = spec.inputs[ref].channel
        if found.log is None and entry is not None:
            _check(f"the input '{ref}'", entry, users, f"the input '{ref}' listens to", problems)
    for ref, sent in outputs.items():
        _check_topic(f"the output '{ref}'", spec.outputs[ref].ros2, problems)
        entry = spec.outputs[ref].channel
        if entry is not None:
            others = {name: use for name, use in users.items() if name != sent.channel.name}
            _check(f"the output '{ref}'", entry, others, f"the output '{ref}' leaves on", problems)
            users |= others


def _check_topic(who: str, entry: Entry | None, problems: list[Problem]) -> None:
    if entry is not None and (reason := why_not_a_topic(str(entry.value.data))):
        problems.append(Problem(entry.value.place, f"{who}: {reason[0]}", reason[1]))


def _check(who: str, entry: Entry, users: dict[str, str], use: str, problems: list[Problem]) -> None:
    """Check a name and add its use to ``users``."""
    name, place = str(entry.value.data), entry.value.place
    if reason := why_not_a_name(name):
        problems.append(Problem(place, f"{who}: {reason[0]}", reason[1] or "choose another name"))
    elif name in users:
        what = f"{who} cannot have the channel '{name}': {users[name]} it"
        problems.append(Problem(place, what, "give each its own channel"))
    users.setdefault(name, use)
