"""Read and write LCM event logs, compatible with LCM's own tools."""

from graphnav.record.channel_filter import ChannelFilter
from graphnav.record.event import Damaged, Event, TruncatedEvent
from graphnav.record.find_log import find_log
from graphnav.record.recording import ABOUT, SMALL_BYTES, Recording
from graphnav.record.sequence_gaps import SequenceGaps
from graphnav.record.threaded_writer import GAP, LogGap, ThreadedLogWriter
from graphnav.record.timeline import Timeline
from graphnav.record.writer import LogWriter
from graphnav.run_folder import LOG

__all__ = [
    "ABOUT",
    "GAP",
    "LOG",
    "SMALL_BYTES",
    "ChannelFilter",
    "Damaged",
    "Event",
    "LogGap",
    "LogWriter",
    "Recording",
    "SequenceGaps",
    "ThreadedLogWriter",
    "Timeline",
    "TruncatedEvent",
    "find_log",
]
