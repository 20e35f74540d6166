"""Serve a live view of a running graph, or of a log: rates, latencies and messages."""

from graphnav.view.live_source import LiveSource
from graphnav.view.log_source import LogSource
from graphnav.view.source import Source
from graphnav.view.web.hosts import is_loopback
from graphnav.view.web.server import PageServer

__all__ = ["LiveSource", "LogSource", "PageServer", "Source", "is_loopback"]
