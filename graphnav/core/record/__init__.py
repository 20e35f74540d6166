"""Read and write LCM event logs, compatible with LCM's own tools."""

from graphnav.core.record.channel_account import ChannelAccount, ChannelCounts, Clock, FirstArrivals, Kind, kind_of
from graphnav.core.record.channel_filter import ChannelFilter
from graphnav.core.record.event import Damaged, Event, TruncatedEvent
from graphnav.core.record.find_log import find_log
from graphnav.core.record.log_cursor import LogCursor
from graphnav.core.record.message_window import Periods, Sizes, Window, silent_after_s
from graphnav.core.record.recording import ABOUT, SMALL_BYTES, Recording
from graphnav.core.record.threaded_writer import GAP, LogGap, ThreadedLogWriter
from graphnav.core.record.timeline import Timeline
from graphnav.core.record.writer import LogWriter
from graphnav.core.run_folder import LOG

__all__ = [
    "ABOUT",
    "GAP",
    "LOG",
    "SMALL_BYTES",
    "ChannelAccount",
    "ChannelCounts",
    "ChannelFilter",
    "Clock",
    "Damaged",
    "Event",
    "FirstArrivals",
    "Kind",
    "LogCursor",
    "LogGap",
    "LogWriter",
    "Periods",
    "Recording",
    "Sizes",
    "ThreadedLogWriter",
    "Timeline",
    "TruncatedEvent",
    "Window",
    "find_log",
    "kind_of",
    "silent_after_s",
]
