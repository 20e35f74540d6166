"""Serve a running graph, or a log, over Foxglove's WebSocket protocol."""

from graphnav.watch.view.foxglove.server import FoxgloveServer

__all__ = ["FoxgloveServer"]
