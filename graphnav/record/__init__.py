"""LCM event logs: what a run leaves, readable by LCM's own tools, and theirs by us."""

from graphnav.record.event import Event, Torn
from graphnav.record.find import LOG, find_log
from graphnav.record.recording import ABOUT, Recording
from graphnav.record.threaded_writer import ThreadedLogWriter
from graphnav.record.writer import LogWriter

__all__ = ["ABOUT", "LOG", "Event", "LogWriter", "Recording", "ThreadedLogWriter", "Torn", "find_log"]
