"""Replaying: a log's sources are played, the stages of its graph step again, and what they publish is compared."""

from graphnav.replay.field_differences import Tolerance
from graphnav.replay.log_graph import LogGraph, graph_to_replay
from graphnav.replay.plan import make_plan, notices_of
from graphnav.replay.replay import ReplayOptions, replay
from graphnav.replay.result import ChannelResult, FieldResult, FirstDifference, ReplayResult
from graphnav.replay.text import as_text

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
