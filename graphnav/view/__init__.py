"""A page that shows a running graph, or a log: who is fast, who is late, and what is in every message."""

from graphnav.view.live_source import LiveSource
from graphnav.view.log_source import LogSource
from graphnav.view.source import Source
from graphnav.view.web.hosts import is_loopback
from graphnav.view.web.server import PageServer

__all__ = ["LiveSource", "LogSource", "PageServer", "Source", "is_loopback"]
