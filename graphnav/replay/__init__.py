"""Replay a log: play its sources, step the stages of its graph again, compare their messages with the recorded ones."""

from graphnav.replay.comparison.field_differences import Tolerance
from graphnav.replay.comparison.result import ChannelResult, FieldResult, FirstDifference, ReplayResult
from graphnav.replay.comparison.result_text import as_text
from graphnav.replay.completed_log import open_completed
from graphnav.replay.log.log_graph import LogGraph, graph_to_replay
from graphnav.replay.plan import make_plan, notices_of
from graphnav.replay.replay import ReplayOptions, replay

__all__ = [
    "ChannelResult",
    "FieldResult",
    "FirstDifference",
    "LogGraph",
    "ReplayOptions",
    "ReplayResult",
    "Tolerance",
    "as_text",
    "graph_to_replay",
    "make_plan",
    "notices_of",
    "open_completed",
    "replay",
]
