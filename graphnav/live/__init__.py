"""Live runs: graphs on the channels of other programs, by the wall clock."""

from graphnav.live.run import live_url, run_live

__all__ = ["live_url", "run_live"]
