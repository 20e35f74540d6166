"""Serve a live view of a running graph, or of a log: rates, latencies and messages."""

from graphnav.watch.view.live_source import LiveSource
from graphnav.watch.view.log_source import LogSource
from graphnav.watch.view.source import Source
from graphnav.watch.view.web.hosts import is_loopback
from graphnav.watch.view.web.server import PageServer

__all__ = ["LiveSource", "LogSource", "PageServer", "Source", "is_loopback"]
