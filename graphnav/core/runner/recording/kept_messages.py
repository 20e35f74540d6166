"""Select the messages of a run that its log keeps."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from graphnav.core.graph import Graph
from graphnav.core.messages import Status
from graphnav.core.record import Recording
from graphnav.core.record.log_files import LogFiles, Split
from graphnav.core.record.threaded_writer import Log
from graphnav.core.runner.engine import Sink
from graphnav.core.spec import RecordOption, RunOptions


def kept(graph: Graph, sink: Sink, channels: Collection[str] | None, *, is_live: bool) -> Sink:
    """Return the sink for the messages of a run of which ``sink``, its log, keeps some.

    ``channels``: the channels to keep, None for the graph's ``record`` option.
    """
    if channels is not None:
        return ChannelsOnly(sink, channels)
    option = record_option(graph.run.record, is_live=is_live)
    if option == "all":
        return sink
    return SmallOnly(sink, complete_channels(graph, option, is_live=is_live) | {Status.CHANNEL})


def record_option(given: RecordOption | None, *, is_live: bool) -> RecordOption:
    """Return what the log of a run keeps: the ``record`` option of its graph, or the default."""
    return given or ("small" if is_live else "replayable")


def open_log(run: RunOptions, path: Path) -> Log:
    """Open the log of a run, in one file, or in several as its options say; raises OSError if that is not possible."""
    n_bytes = None if run.rotate_mb is None else round(run.rotate_mb * 1e6)
    us = None if run.rotate_s is None else round(run.rotate_s * 1e6)
    return LogFiles(path, Split(n_bytes, us), numbers_first=False)


def complete_channels(graph: Graph, option: RecordOption, *, is_live: bool) -> frozenset[str]:
    """Return the names of the channels of which a log keeps every message.

    ``replayable``: those that no replay makes again, which are inputs, outputs of agents and of sources, except
    reproducible ones of a lockstep run; and those with which sources of reproducible outputs were stepped.
    """
    if option == "small":
        return frozenset()
    if option == "all":
        return frozenset(channel.name for channel in graph.channels.values())
    found = {graph.channels[ref].name for ref in graph.inputs}
    found.update(channel.name for node in graph.nodes if node.stage_class.is_agent for channel in node.outputs.values())
    for node in graph.sources:
        left_out = () if is_live else node.reproducible
        found.update(channel.name for channel in node.outputs.values() if channel not in left_out)
        if left_out:
            found.update(i.channel.name for i in node.inputs if i.channel is not None)
    return frozenset(found)


class SmallOnly:
    """Passes on messages below 4 kB, the first of every channel of any size, and every one of ``complete`` channels.

    The first of a channel may be its only one: the map is published once.
    """

    def __init__(self, sink: Sink, complete: Collection[str] = ()) -> None:
        self._sink = sink
        self._complete = frozenset(complete)
        self._begun: set[str] = set()

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if len(data) < Recording.SMALL_BYTES or channel not in self._begun or channel in self._complete:
            self._begun.add(channel)
            self._sink.write(channel, utime, data)


class ChannelsOnly:
    """Passes on the messages of given channels."""

    def __init__(self, sink: Sink, channels: Collection[str]) -> None:
        self._sink = sink
        self._channels = frozenset(channels)

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message."""
        if channel in self._channels:
            self._sink.write(channel, utime, data)
