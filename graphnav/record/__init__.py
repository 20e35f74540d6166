"""LCM event logs: what a run leaves, readable by LCM's own tools, and theirs by us."""

from graphnav.codec import lcm_text_of
from graphnav.record.event import Event, Torn
from graphnav.record.recording import ABOUT, Recording
from graphnav.record.writer import LogWriter

__all__ = ["ABOUT", "Event", "LogWriter", "Recording", "Torn", "lcm_text_of"]
