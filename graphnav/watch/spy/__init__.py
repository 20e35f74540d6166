"""Show the channels of a multicast group or a log: types, rates, sizes, contents."""

from graphnav.watch.spy.health import health_as_json, health_as_text
from graphnav.watch.spy.traffic_report import (
    as_json,
    as_text,
    rates_as_json,
    silence_of,
    size_of,
    sizes_as_json,
    volume,
)

__all__ = [
    "as_json",
    "as_text",
    "health_as_json",
    "health_as_text",
    "rates_as_json",
    "silence_of",
    "size_of",
    "sizes_as_json",
    "volume",
]
