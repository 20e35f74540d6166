"""Foxglove's channels with its schemas, which it shows without a plugin; on a file, MCAP."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from graphnav.core.codec import fields_of, lcm_name
from graphnav.core.errors import printable, shown_name
from graphnav.watch.export.entries.entries import Beams, Entry, Level, Line, Picture, Scalars
from graphnav.watch.export.entries.topics import Topics
from graphnav.watch.export.extras import require
from graphnav.watch.export.files import QuietFile
from graphnav.watch.export.foxglove_scene import (
    MAP_TOPIC,
    PATH_TOPIC,
    POSE_TOPIC,
    ROBOT_TOPIC,
    TRANSFORM_TOPIC,
    scan_message,
    scene_messages,
)
from graphnav.watch.export.scalar_fields import has_few_elements

LOG_TOPIC = "/log"
TOPICS = {
    LOG_TOPIC: "Log",
    MAP_TOPIC: "SceneUpdate",
    ROBOT_TOPIC: "SceneUpdate",
    PATH_TOPIC: "SceneUpdate",
    POSE_TOPIC: "PoseInFrame",
    TRANSFORM_TOPIC: "FrameTransform",
}
"""The Foxglove types of the topics that do not belong to one channel."""
_LEVELS = {Level.INFO: "Info", Level.WARNING: "Warning", Level.ERROR: "Error"}
_TYPES = {"float": "number", "double": "number", "boolean": "boolean", "string": "string"}


class McapFile:
    """Writes entries as Foxglove messages with log time."""

    def __init__(self, file: Path) -> None:
        foxglove = require("foxglove")
        context = foxglove.Context()
        self._file = QuietFile(file)
        self._writer = foxglove.open_mcap(self._file, context=context)
        self._channels = FoxgloveChannels(context)

    def add(self, entry: Entry) -> None:
        """Write an entry; raises OSError if writing fails."""
        self._channels.add(entry)
        self._file.check()

    def close(self) -> None:
        """Write buffered data and the index for seeking."""
        try:
            self._writer.close()
        finally:
            self._file.close()


class FoxgloveChannels:
    """Logs entries, with their timestamps, to a ``context`` of the SDK, which feeds files and servers.

    Topics: a channel's scalars as JSON on ``/stage/port``, its pictures (PNG) on ``/stage/port/picture``, its scans as
    LaserScan on ``/stage/port/beams``; the map, the path and the robot on ``/scene/...`` and ``/tf``; lines of text on
    ``/log``. A topic is created with its first message, or earlier by ``offer...``, so that clients can subscribe.
    """

    def __init__(self, context: Any) -> None:
        self._foxglove = require("foxglove")
        self._types, self._kinds = require("foxglove.messages"), require("foxglove.channels")
        self._context = context
        self._topics = Topics(TOPICS)
        self._channels: dict[str, Any] = {}
        self._schemas: dict[type, dict[str, Any]] = {}

    def scalars_topic(self, channel: str) -> str:
        """Return the topic of a channel's scalars."""
        return self._topics.of(channel)

    def picture_topic(self, channel: str) -> str:
        """Return the topic of a channel's pictures."""
        return self._topics.picture_of(channel)

    def beams_topic(self, channel: str) -> str:
        """Return the topic of a channel's scans."""
        return self._topics.beams_of(channel)

    def offer(self, topic: str) -> None:
        """Create one of `TOPICS`."""
        self._typed(topic, TOPICS[topic])

    def offer_scalars(self, channel: str, lcm_class: type) -> None:
        """Create the topic of a channel's scalars."""
        topic = self.scalars_topic(channel)
        if topic not in self._channels:
            self._channels[topic] = self._foxglove.Channel(topic, schema=self._schema(lcm_class), context=self._context)

    def offer_picture(self, channel: str) -> None:
        """Create the topic of a channel's pictures."""
        self._typed(self.picture_topic(channel), "CompressedImage")

    def offer_beams(self, channel: str) -> None:
        """Create the topic of a channel's scans."""
        self._typed(self.beams_topic(channel), "LaserScan")

    def withdraw(self, topic: str) -> None:
        """Close a topic, if it exists."""
        if (ended := self._channels.pop(topic, None)) is not None:
            ended.close()

    def withdraw_channel(self, channel: str) -> None:
        """Close the topics of a channel."""
        self.withdraw(self.scalars_topic(channel))
        self.withdraw(self.picture_topic(channel))
        self.withdraw(self.beams_topic(channel))
        self._topics.forget(channel)

    def is_wanted(self, topic: str) -> bool:
        """Whether a topic has a subscriber."""
        made = self._channels.get(topic)
        return made is not None and bool(made.has_sinks())

    def add(self, entry: Entry) -> None:
        """Log an entry."""
        if isinstance(entry, Scalars):
            self.offer_scalars(entry.channel, entry.lcm_class)
            values = values_of(self._schema(entry.lcm_class), entry.fields)
            self._channels[self.scalars_topic(entry.channel)].log(values, log_time=entry.utime * 1000)
        elif isinstance(entry, Picture):
            picture = self._types.CompressedImage(
                timestamp=self._stamp(entry.utime),
                frame_id=shown_name(entry.channel),
                data=entry.png(),
                format="png",
            )
            self._log(self.picture_topic(entry.channel), picture, entry.utime)
        elif isinstance(entry, Beams):
            scan = scan_message(self._types, entry, self._stamp(entry.utime))
            self._log(self.beams_topic(entry.channel), scan, entry.utime)
        elif isinstance(entry, Line):
            line = self._types.Log(
                timestamp=self._stamp(entry.utime),
                level=getattr(self._types.LogLevel, _LEVELS[entry.level]),
                message=printable(entry.text),
                name=shown_name(entry.source),
            )
            self._log(LOG_TOPIC, line, entry.utime)
        else:
            for topic, message in scene_messages(self._types, entry, self._stamp(entry.utime)):
                self._log(topic, message, entry.utime)

    def _schema(self, lcm_class: type) -> dict[str, Any]:
        schema = self._schemas.get(lcm_class)
        if schema is None:
            schema = self._schemas[lcm_class] = schema_of(lcm_class)
        return schema

    def _typed(self, topic: str, type_name: str) -> Any:
        """Return the channel of a topic with a Foxglove type."""
        made = self._channels.get(topic)
        if made is None:
            kind = getattr(self._kinds, f"{type_name}Channel")
            made = self._channels[topic] = kind(topic, context=self._context)
        return made

    def _log(self, topic: str, message: Any, utime: int) -> None:
        """Log a message of a Foxglove type."""
        self._typed(topic, type(message).__name__).log(message, log_time=utime * 1000)

    def _stamp(self, utime: int) -> Any:
        seconds, rest_us = divmod(utime, 1_000_000)
        return self._types.Timestamp(sec=seconds, nsec=rest_us * 1000)


def schema_of(lcm_class: type) -> dict[str, Any]:
    """Return the JSON schema of the scalars of an LCM type: including nested structs and small fixed arrays."""
    properties: dict[str, Any] = {}
    fields = fields_of(lcm_class)
    sizes = {dim for field in fields for dim in field.dims}
    for field in fields:
        if field.name in sizes or not has_few_elements(field):
            continue
        part = {"type": _TYPES.get(field.primitive, "integer")} if field.struct is None else schema_of(field.struct)
        for _ in field.dims:
            part = {"type": "array", "items": part}
        properties[field.name] = part
    return {"title": lcm_name(lcm_class), "type": "object", "properties": properties}


def values_of(schema: dict[str, Any], value: Any) -> Any:
    """Return decoded LCM fields as JSON-compatible values; non-finite numbers are left out, in arrays null."""
    if "properties" in schema:
        parts = {name: values_of(part, value[name]) for name, part in schema["properties"].items()}
        return {name: part for name, part in parts.items() if part is not None}
    if "items" in schema:
        return [values_of(schema["items"], element) for element in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
