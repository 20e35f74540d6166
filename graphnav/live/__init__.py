"""Live runs: graphs on the channels of other programs, by the wall clock."""

from graphnav.live.run import run_live
from graphnav.live.url import live_url

__all__ = ["live_url", "run_live"]
