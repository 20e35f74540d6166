"""Read and write LCM event logs, compatible with LCM's own tools."""

from graphnav.record.channel_filter import ChannelFilter
from graphnav.record.event import Damaged, Event, TruncatedEvent
from graphnav.record.find_log import find_log
from graphnav.record.recording import ABOUT, Recording
from graphnav.record.sequence_gaps import SequenceGaps
from graphnav.record.threaded_writer import ThreadedLogWriter
from graphnav.record.timeline import Timeline
from graphnav.record.writer import LogWriter
from graphnav.run_folder import LOG

__all__ = [
    "ABOUT",
    "LOG",
    "ChannelFilter",
    "Damaged",
    "Event",
    "LogWriter",
    "Recording",
    "SequenceGaps",
    "ThreadedLogWriter",
    "Timeline",
    "TruncatedEvent",
    "find_log",
]
