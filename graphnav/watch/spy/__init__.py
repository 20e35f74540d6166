"""Show the channels of a multicast group or a log: types, rates, sizes, contents."""

from graphnav.core.fields import (
    MISSING,
    FieldPath,
    Selection,
    all_columns,
    columns_of,
    described,
    nested,
    parse_field,
    plain,
    summarised,
)
from graphnav.watch.spy.announcements import Announcements
from graphnav.watch.spy.feed import Feed, Received, drops_of
from graphnav.watch.spy.feed_listener import FeedListener
from graphnav.watch.spy.health.health import Health
from graphnav.watch.spy.health.health_json import health_as_json
from graphnav.watch.spy.health.health_text import health_as_text
from graphnav.watch.spy.traffic import MAX_CHANNELS, ChannelTraffic, Traffic
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
    "MAX_CHANNELS",
    "MISSING",
    "Announcements",
    "ChannelTraffic",
    "Feed",
    "FeedListener",
    "FieldPath",
    "Health",
    "Received",
    "Selection",
    "Traffic",
    "all_columns",
    "as_json",
    "as_text",
    "columns_of",
    "described",
    "drops_of",
    "health_as_json",
    "health_as_text",
    "nested",
    "parse_field",
    "plain",
    "rates_as_json",
    "silence_of",
    "size_of",
    "sizes_as_json",
    "summarised",
    "volume",
]
