"""Live runs: graphs on the channels of other programs, by the wall clock."""

from graphnav.live.about import STATUS
from graphnav.live.run import live_url, run_live

__all__ = ["STATUS", "live_url", "run_live"]
