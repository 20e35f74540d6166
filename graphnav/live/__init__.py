"""Live runs: graphs in wall time, connected to channels of other programs."""

from graphnav.live.run import run_live
from graphnav.live.url import live_url

__all__ = ["live_url", "run_live"]
