"""The full-screen ``graphnav spy``: a table of channels, and a view of one channel: fields, plots, picture."""

from graphnav.spy.feed import Feed
from graphnav.spy.screen.app import SpyApp
from graphnav.spy.screen.painters.choose_painter import painters
from graphnav.spy.screen.run_app import run_app
from graphnav.spy.watch.live_watch import LiveWatch
from graphnav.spy.watch.log_watch import LogWatch

__all__ = ["SpyApp", "painters", "run_app", "watch_of"]


def watch_of(feed: Feed) -> LiveWatch | LogWatch:
    """Return the watch of a feed; raises LogError if a log cannot be read."""
    return LiveWatch(feed) if feed.is_live else LogWatch(feed)
