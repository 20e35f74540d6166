"""Publish messages whose fields are given as YAML."""

from graphnav.publish.fields import Fields, parse_fields
from graphnav.publish.publisher import Publisher, repeat

__all__ = ["Fields", "Publisher", "parse_fields", "repeat"]
