"""Choose how to step the stages: by the ticks of a lockstep run, or by the firings of a live run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from graphnav import Recording, Stage, UserError
from graphnav.core.runner import Sink
from graphnav.replay.log.changes import make_changes
from graphnav.replay.log.check_log import reach_of, refuse_unlogged, refuse_unread, refuse_unreadable
from graphnav.replay.log.contents import Contents
from graphnav.replay.log.firings import read_firings
from graphnav.replay.log.log_graph import LogGraph
from graphnav.replay.log.reproduction import Reproduction
from graphnav.replay.log.schedule import ticks_of
from graphnav.replay.plan import Plan
from graphnav.replay.stepping.firing_log import FiringLog
from graphnav.replay.stepping.firing_replay import FiringReplay
from graphnav.replay.stepping.reproduced_sources import ReproducedSources
from graphnav.replay.stepping.tick_replay import Sinks, TickReplay, Timetable

_SEQ = slice(16, 24)
"""Position of the sequence number in a message, after the fingerprint and the timestamp."""

Make = Callable[[Mapping[str, Stage], Sequence[Sink], Sink | None], TickReplay | FiringReplay]


@dataclass(frozen=True)
class Session:
    """A factory of the replay's schedule: from stages, sinks for their messages, and the log of the replay.

    ``last_us``: the run's clock at the last tick or firing of the log, which may be incomplete.
    """

    make: Make
    last_us: int
    lost: tuple[str, ...] = ()
    """Consequences of damage of the log."""


def lockstep_session(
    recording: Recording,
    made: LogGraph,
    plan: Plan,
    contents: Contents,
    start_us: int,
    reproduction: Reproduction | None = None,
) -> Session:
    """Return the session that replays a lockstep run from a timestamp on.

    ``reproduction``: the sources that make again what the log leaves out, from its start on.

    Raises
    ------
    UserError
        Required messages are missing, or the graph does not run in lockstep.
    """
    if plan.graph.inputs:
        what = f"the graph has inputs ({', '.join(plan.graph.inputs)}), but the log was recorded in lockstep"
        raise UserError.of(what, "replay it with a graph that runs in lockstep")
    refuse_unreadable(plan, contents, recording, made.about)
    refuse_unread(plan, contents, recording, made.wires)
    reach = reach_of(plan, contents, recording, start_us, made.complete, reproduction)
    is_complete = all(channel.name in made.complete for channel in plan.graph.channels.values())
    held = (*plan.played, *plan.copied)
    changes = tuple(make_changes(plan.changes, plan.began, plan.stepped_names))
    every = ticks_of(plan.graph, held, contents, is_complete=is_complete)
    ticks = [tick for tick in every if start_us <= tick.utime <= reach.until_us]
    earlier = ([m for m in contents.messages[channel.name] if m.utime < start_us] for channel in plan.needed)
    before = [messages[-1] for messages in earlier if messages]

    def make(stages: Mapping[str, Stage], sinks: Sequence[Sink], log: Sink | None) -> TickReplay:
        logs = () if log is None else (Renumbered(log) if start_us else log,)
        again = None
        if reproduction is not None:
            again = ReproducedSources(reproduction, reproduction.make_stages(), recording, contents)
        timetable = Timetable(
            ticks, before, start_us, *((contents.last_us, contents.stops) if math.isinf(reach.until_us) else (0, ()))
        )
        return TickReplay(plan, stages, recording, timetable, Sinks(sinks, logs), again, changes)

    return Session(make, contents.last_us, reach.lost)


def live_session(recording: Recording, made: LogGraph, plan: Plan, contents: Contents, start_us: int) -> Session:
    """Return the session that replays a live run from a time of the run's clock on.

    Raises
    ------
    UserError
        Required messages are missing.
    """
    refuse_unreadable(plan, contents, recording, made.about)
    logged = read_firings(plan, contents, recording, made.wires)
    refuse_unlogged(plan, contents, recording, logged, made.complete)
    changes = tuple(make_changes(plan.changes, plan.began, plan.stepped_names))

    def make(stages: Mapping[str, Stage], sinks: Sequence[Sink], log: Sink | None) -> FiringReplay:
        firing_log = None if log is None else FiringLog(log)
        begin_us = recording.begin_us
        return FiringReplay(plan, stages, recording, logged, sinks, firing_log, begin_us, start_us, changes)

    last_us = logged.firings[-1].at_us
    if not logged.is_cut:
        return Session(make, last_us)
    done_s = (last_us - recording.begin_us) / 1e6
    return Session(make, last_us, (f"replayed up to {done_s:.2f} s; messages that later firings read are missing",))


class Renumbered:
    """The log of a replay that starts later than the run: the numbers of each channel start at 0; gaps stay."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._first: dict[str, int] = {}

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Pass a message on."""
        seq = int.from_bytes(data[_SEQ], "big", signed=True)
        first = self._first.setdefault(channel, seq)
        number = (seq - first) & (1 << 64) - 1
        self._sink.write(channel, utime, data[: _SEQ.start] + number.to_bytes(8, "big") + data[_SEQ.stop :])
