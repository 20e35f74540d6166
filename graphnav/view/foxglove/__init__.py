"""Serve a running graph, or a log, over Foxglove's WebSocket protocol."""

from graphnav.view.foxglove.live_feed import LiveFeed
from graphnav.view.foxglove.log_player import LogPlayer
from graphnav.view.foxglove.server import FoxgloveServer

__all__ = ["FoxgloveServer", "LiveFeed", "LogPlayer"]
