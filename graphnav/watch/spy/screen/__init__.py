"""The full-screen ``graphnav spy``: a table of channels, and a view of one channel: fields, plots, picture."""

from graphnav.watch.feed import Feed
from graphnav.watch.spy.live_watch import LiveWatch
from graphnav.watch.spy.log_watch import LogWatch
from graphnav.watch.spy.screen.app import SpyApp, run_app
from graphnav.watch.spy.screen.painters.choose_painter import painters

__all__ = ["SpyApp", "painters", "run_app", "watch_of"]


def watch_of(feed: Feed) -> LiveWatch | LogWatch:
    """Return the watch of a feed; raises LogError if a log cannot be read."""
    return LiveWatch(feed) if feed.is_live else LogWatch(feed)
