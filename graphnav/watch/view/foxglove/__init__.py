"""Serve a running graph, or a log, over Foxglove's WebSocket protocol."""

from graphnav.watch.view.foxglove.live_feed import LiveFeed
from graphnav.watch.view.foxglove.log_player import LogPlayer
from graphnav.watch.view.foxglove.server import FoxgloveServer

__all__ = ["FoxgloveServer", "LiveFeed", "LogPlayer"]
