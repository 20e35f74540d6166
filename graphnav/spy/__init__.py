"""Watching: which channels there are, what goes over them and how fast, live or in a log."""

from graphnav.spy.contents import described, summarised
from graphnav.spy.feed import Feed, Heard
from graphnav.spy.health import Health
from graphnav.spy.health_json import health_as_json
from graphnav.spy.health_text import health_as_text
from graphnav.spy.report import as_json, as_text, silence_of, size_of, volume
from graphnav.spy.traffic import ChannelTraffic, Traffic
from graphnav.spy.window import Periods

__all__ = [
    "ChannelTraffic",
    "Feed",
    "Health",
    "Heard",
    "Periods",
    "Traffic",
    "as_json",
    "as_text",
    "described",
    "health_as_json",
    "health_as_text",
    "silence_of",
    "size_of",
    "summarised",
    "volume",
]
