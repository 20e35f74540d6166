"""Read and write LCM event logs, compatible with LCM's own tools."""

from graphnav.core.record.about_first import AboutFirst
from graphnav.core.record.bags import BagWriter
from graphnav.core.record.channel_filter import ChannelFilter
from graphnav.core.record.event import Damaged, Event, TruncatedEvent
from graphnav.core.record.index import Timeline
from graphnav.core.record.log_files import LogFiles, Split
from graphnav.core.record.log_paths import files_of, find_log, parts_of
from graphnav.core.record.message_window import RECENT_S, Periods, Sizes, Window, silent_after_s
from graphnav.core.record.recording import Head, Recording
from graphnav.core.record.threaded_writer import LogGap, ThreadedLogWriter
from graphnav.core.record.writer import LogWriter

__all__ = [
    "RECENT_S",
    "AboutFirst",
    "BagWriter",
    "ChannelFilter",
    "Damaged",
    "Event",
    "Head",
    "LogFiles",
    "LogGap",
    "LogWriter",
    "Periods",
    "Recording",
    "Sizes",
    "Split",
    "ThreadedLogWriter",
    "Timeline",
    "TruncatedEvent",
    "Window",
    "files_of",
    "find_log",
    "parts_of",
    "silent_after_s",
]
