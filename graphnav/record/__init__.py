"""LCM event logs: what a run leaves, readable by LCM's own tools, and theirs by us."""

from graphnav.record.channel_filter import ChannelFilter
from graphnav.record.event import Damaged, Event, Torn
from graphnav.record.find import find_log
from graphnav.record.recording import ABOUT, Recording
from graphnav.record.sequence import SequenceGaps
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
    "Torn",
    "find_log",
]
