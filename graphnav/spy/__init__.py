"""Watching: which channels there are, what goes over them and how fast, live or in a log."""

from graphnav.spy.contents import described, summarised
from graphnav.spy.report import as_json, as_text, size_of, volume
from graphnav.spy.source import Heard, Source
from graphnav.spy.traffic import ChannelTraffic, Traffic

__all__ = [
    "ChannelTraffic",
    "Heard",
    "Source",
    "Traffic",
    "as_json",
    "as_text",
    "described",
    "size_of",
    "summarised",
    "volume",
]
