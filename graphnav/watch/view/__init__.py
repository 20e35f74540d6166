"""Serve a live view of a running graph, or of a log: rates, latencies and messages."""

from graphnav.watch.view.page_feed import PageFeed
from graphnav.watch.view.web.hosts import is_loopback
from graphnav.watch.view.web.server import PageServer

__all__ = ["PageFeed", "PageServer", "is_loopback"]
