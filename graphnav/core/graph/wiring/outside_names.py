"""LCM channels of inputs and outputs: legal names, one writer each."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.core.errors import Problem
from graphnav.core.graph.node import Channel, InputChannel, OutputChannel
from graphnav.core.graph.wiring.channels import why_not_a_name
from graphnav.core.spec import Entry, Spec


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
        entry = spec.inputs[ref].channel
        if found.log is None and entry is not None:
            _check(f"the input '{ref}'", entry, users, f"the input '{ref}' listens to", problems)
    for ref, sent in outputs.items():
        entry = spec.outputs[ref].channel
        if entry is not None:
            others = {name: use for name, use in users.items() if name != sent.channel.name}
            _check(f"the output '{ref}'", entry, others, f"the output '{ref}' leaves on", problems)
            users |= others


def _check(who: str, entry: Entry, users: dict[str, str], use: str, problems: list[Problem]) -> None:
    """Check a name and add its use to ``users``."""
    name, place = str(entry.value.data), entry.value.place
    if reason := why_not_a_name(name):
        problems.append(Problem(place, f"{who}: {reason[0]}", reason[1] or "choose another name"))
    elif name in users:
        what = f"{who} cannot have the channel '{name}': {users[name]} it"
        problems.append(Problem(place, what, "give each its own channel"))
    users.setdefault(name, use)
