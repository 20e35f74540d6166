"""Publish messages whose fields are given as YAML."""

from graphnav.live.publish.fields import Fields, parse_fields
from graphnav.live.publish.publisher import Publisher, repeat

__all__ = ["Fields", "Publisher", "parse_fields", "repeat"]
