"""Replaying: a log's sources are played, the stages of its graph step again, and what they publish is compared."""

from graphnav.replay.comparison.field_differences import Tolerance
from graphnav.replay.comparison.result import ChannelResult, FieldResult, FirstDifference, ReplayResult
from graphnav.replay.comparison.result_text import as_text
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
    "replay",
]
