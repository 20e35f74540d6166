"""Live graphs: what comes from other programs, judged before a stage sees it."""

from graphnav.live.sender import SenderMonitor, Verdict

__all__ = ["SenderMonitor", "Verdict"]
