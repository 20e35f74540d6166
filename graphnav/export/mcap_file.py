"""A run as MCAP with Foxglove's own schemas: Foxglove shows it without a plugin."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from graphnav.export.entries import Entry, Level, Line, Picture, Scalars
from graphnav.export.extras import require
from graphnav.export.json_schema import schema_of, values_of
from graphnav.export.mcap_scene import scene_messages
from graphnav.export.quiet_file import QuietFile
from graphnav.export.topics import topics_of

LOG_TOPIC = "/log"
PICTURE = "picture"
"""The last part of the topic of a channel's pictures."""

_LEVELS = {Level.INFO: "Info", Level.WARNING: "Warning", Level.ERROR: "Error"}


class McapFile:
    """Writes entries as messages of Foxglove, stamped with the time of the log.

    Topics: a channel's scalars as JSON on ``/stage/port``, its pictures (PNG) on ``/stage/port/picture``; the map, the
    path and the robot on ``/scene/...`` and ``/tf``; lines of text on ``/log``.
    """

    def __init__(self, file: Path, channels: Iterable[str]) -> None:
        self._foxglove = require("foxglove")
        self._types, self._kinds = require("foxglove.messages"), require("foxglove.channels")
        self._context = self._foxglove.Context()
        self._file = QuietFile(file)
        self._writer = self._foxglove.open_mcap(self._file, context=self._context)
        self._topics = topics_of(channels)
        self._channels: dict[str, Any] = {}
        self._schemas: dict[type, dict[str, Any]] = {}

    def add(self, entry: Entry) -> None:
        """Write an entry; raises OSError where the disk refuses."""
        if isinstance(entry, Scalars):
            self._add_scalars(entry)
        elif isinstance(entry, Picture):
            picture = self._types.CompressedImage(
                timestamp=self._stamp(entry.utime), frame_id=entry.channel, data=entry.png(), format="png"
            )
            self._log(f"{self._topics[entry.channel]}/{PICTURE}", picture, entry.utime)
        elif isinstance(entry, Line):
            line = self._types.Log(
                timestamp=self._stamp(entry.utime),
                level=getattr(self._types.LogLevel, _LEVELS[entry.level]),
                message=entry.text,
                name=entry.source,
            )
            self._log(LOG_TOPIC, line, entry.utime)
        else:
            for topic, message in scene_messages(self._types, entry, self._stamp(entry.utime)):
                self._log(topic, message, entry.utime)
        self._file.check()

    def close(self) -> None:
        """Write what is left, and the index by which viewers seek."""
        try:
            self._writer.close()
        finally:
            self._file.close()

    def _add_scalars(self, entry: Scalars) -> None:
        schema = self._schemas.get(entry.lcm_class)
        if schema is None:
            schema = self._schemas[entry.lcm_class] = schema_of(entry.lcm_class)
        topic = self._topics[entry.channel]
        if topic not in self._channels:
            self._channels[topic] = self._foxglove.Channel(topic, schema=schema, context=self._context)
        self._channels[topic].log(values_of(schema, entry.fields), log_time=entry.utime * 1000)

    def _log(self, topic: str, message: Any, utime: int) -> None:
        """Write a message of one of Foxglove's types."""
        if topic not in self._channels:
            kind = getattr(self._kinds, f"{type(message).__name__}Channel")
            self._channels[topic] = kind(topic, context=self._context)
        self._channels[topic].log(message, log_time=utime * 1000)

    def _stamp(self, utime: int) -> Any:
        seconds, rest_us = divmod(utime, 1_000_000)
        return self._types.Timestamp(sec=seconds, nsec=rest_us * 1000)
