"""Check that a log holds what a replay needs, or find the replayable part of a damaged log."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any, NamedTuple

from graphnav import About, Recording, UserError
from graphnav.core.graph import Channel
from graphnav.core.large_messages import PACKET_BYTES
from graphnav.replay.log.contents import Contents
from graphnav.replay.log.firings import LoggedFirings
from graphnav.replay.log.missing_messages import MissingMessages, is_first_only, missing_messages
from graphnav.replay.log.reproduction import Reproduction
from graphnav.replay.plan import Plan

Wires = Mapping[str, Mapping[str, Any]]

_HINT = (
    "record what a replay needs: --set run.record=replayable, 'graphnav run --tap full' for a logger; "
    "or play the outputs of these stages with --play"
)


def refuse_unreadable(plan: Plan, contents: Contents, recording: Recording, about: About | None) -> None:
    """Refuse a log with messages that the graph cannot read.

    Raises
    ------
    UserError
        A required channel has another type, or was thinned by the tap.
    """
    _refuse_other_types(plan, contents, recording)
    _refuse_thinned(plan, contents, recording, about)


def refuse_unlogged(
    plan: Plan, contents: Contents, recording: Recording, logged: LoggedFirings, complete: Collection[str]
) -> None:
    """Refuse a live log without the messages of new wires, which were not read in the run.

    Raises
    ------
    UserError
        It has no messages of such a channel, or only the first one because the channel is not ``complete``.
    """
    newly = {
        i.channel.name
        for node in plan.stepped.nodes
        for i in node.inputs
        if i.channel is not None and (node.name in logged.added or (node.name, i.port.name) in logged.new_ports)
    }
    lines = []
    for channel in plan.played:
        found = contents.messages[channel.name]
        if channel.name not in newly or (found and (channel.name in complete or not is_first_only(found, contents))):
            continue
        lines.append(f"{channel.name}: {'all but 1' if found else 'all of them'}")
    if lines:
        readers = ", ".join(sorted({n for c in plan.played if c.name in newly for n in plan.readers_of(c)}))
        what = f"{recording.path} is missing messages that {readers} read:"
        raise UserError.of("\n  ".join([what, *lines]), _hint(recording))


def refuse_unread(plan: Plan, contents: Contents, recording: Recording, wires: Wires) -> None:
    """Refuse a lockstep log without any message that a new stage would fire on, because nothing read it in the run.

    ``wires``: the channels read in the run, by stage and port.

    Raises
    ------
    UserError
        There are such channels (`Stage.is_read`).
    """
    if not wires:
        return
    read = {str(ref) for ports in wires.values() for ref in ports.values()}
    firing = {i.channel for node in plan.stepped.nodes for i in node.inputs if i.port.is_plain}
    unread = [c for c in plan.needed if c in firing and c.ref not in read and not contents.messages[c.name]]
    if unread:
        readers = ", ".join(sorted({name for channel in unread for name in plan.readers_of(channel)}))
        lines = [f"{channel.name}: all of them, because nothing read it in the recorded run" for channel in unread]
        what = f"{recording.path} is missing messages that {readers} read:"
        raise UserError.of("\n  ".join([what, *lines]), f"run the graph again with {readers}")


class Reach(NamedTuple):
    """The replayable part of a log: its end (infinity for the complete log), and what is missing after it."""

    until_us: float
    lost: tuple[str, ...] = ()


def reach_of(
    plan: Plan,
    contents: Contents,
    recording: Recording,
    start_us: int,
    complete: Collection[str],
    reproduction: Reproduction | None,
) -> Reach:
    """Return the replayable part of a log from ``start_us`` on.

    Messages of ``complete`` channels, of which the run has recorded everything, are missing only through damage: then
    the part before the damage is used.

    Raises
    ------
    UserError
        Messages were never recorded, or are missing from the beginning.
    """
    incomplete: dict[Channel, list[MissingMessages]] = {}
    for channel in plan.needed:
        missing = [part for part in missing_messages(channel, plan, contents) if part.before_us > start_us]
        if missing:
            incomplete[channel] = missing
    names = {name for channel in incomplete for name in plan.readers_of(channel)}
    if reproduction is not None:
        lacking = dict(reproduction.missing_inputs(contents))
        names.update(node.name for node in reproduction.nodes if any(i.channel in lacking for i in node.inputs))
        incomplete.update(lacking)
    if not incomplete:
        return Reach(math.inf)
    readers = ", ".join(sorted(names))
    until_us = min(missing[0].after_us for missing in incomplete.values())
    is_damage = contents.is_own and all(channel.name in complete for channel in incomplete)
    if (contents.lost or is_damage) and until_us >= start_us:
        lines = "; ".join(_lines(incomplete, contents))
        return Reach(until_us, (f"replayed up to {until_us / 1e6:.2f} s; later messages are missing: {lines}",))
    what = f"{recording.path} is missing messages that {readers} read:"
    raise UserError.of("\n  ".join([what, *_lines(incomplete, contents)]), _hint(recording))


def _hint(recording: Recording) -> str:
    return f"{recording.completion_hint}, and replay that" if recording.completion_hint else _HINT


def _lines(incomplete: Mapping[Channel, list[MissingMessages]], contents: Contents) -> Iterator[str]:
    for channel, missing in incomplete.items():
        kept = len(contents.messages[channel.name])
        if not kept:
            yield f"{channel.name}: all of them"
            continue
        n_missing = sum(part.n_messages for part in missing) if all(part.n_messages for part in missing) else 0
        share = f"{n_missing} of {n_missing + kept}" if n_missing else f"all but {kept}"
        after_us = missing[0].after_us
        yield f"{channel.name}: {share}, " + (
            f"the first after {after_us / 1e6:.2f} s" if math.isfinite(after_us) else "from the first on"
        )


def _refuse_other_types(plan: Plan, contents: Contents, recording: Recording) -> None:
    for channel in plan.needed:
        if channel.name in contents.other_types:
            what = (
                f"channel '{channel.name}' of {recording.path} is not {channel.message.__name__}, the type in the graph"
            )
            raise UserError.of(what, "replay it with the graph that produced it")


def _refuse_thinned(plan: Plan, contents: Contents, recording: Recording, about: About | None) -> None:
    """Refuse grids that were thinned by the tap, which reduces messages larger than one packet."""
    if about is None or not about.run_id:
        return
    for channel in plan.needed:
        messages = contents.messages[channel.name]
        if not messages or not channel.message.grid or not PACKET_BYTES / 4 < messages[0].n_bytes <= PACKET_BYTES:
            continue
        step_px = recording.fields(channel.name, messages[0].place).get("step_px", 1)
        if step_px > 1:
            what = f"'{channel.name}' of {recording.path} was thinned by the tap: its step_px is {step_px}"
            raise UserError.of(what, "record a run with --tap full, or replay the log in its run folder")
