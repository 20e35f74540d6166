"""Merge the logs of several computers on one time line, with their clocks measured."""

from graphnav.watch.merge.clock_offset import ClockOffset
from graphnav.watch.merge.merge_logs import Merged, MergedLog, NamedLog, merge_logs
from graphnav.watch.merge.shared_messages import Way

__all__ = ["ClockOffset", "Merged", "MergedLog", "NamedLog", "Way", "merge_logs"]
