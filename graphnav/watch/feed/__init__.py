"""One library for watching: a feed, live or a log, and one account of all that it sends."""

from graphnav.watch.feed.announcements import MAX_RUNS, RUN_SILENT_S, Announcements
from graphnav.watch.feed.channel import KEPT_MESSAGES, WatchedChannel
from graphnav.watch.feed.feed import Feed, Received, drops_of, host_of
from graphnav.watch.feed.health import GuardHealth, Health, RunHealth
from graphnav.watch.feed.live_feed import LiveFeed, StoppableThread
from graphnav.watch.feed.log_feed import LogFeed, Past
from graphnav.watch.feed.watch import MAX_CHANNELS, Watch

__all__ = [
    "KEPT_MESSAGES",
    "MAX_CHANNELS",
    "MAX_RUNS",
    "RUN_SILENT_S",
    "Announcements",
    "Feed",
    "GuardHealth",
    "Health",
    "LiveFeed",
    "LogFeed",
    "Past",
    "Received",
    "RunHealth",
    "StoppableThread",
    "Watch",
    "WatchedChannel",
    "drops_of",
    "host_of",
]
