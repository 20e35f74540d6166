"""Read the decoded messages of a selection of a log, and count undecodable ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, NamedTuple

from graphnav import Adapter, Message, Recording
from graphnav.core.catalog import Catalog
from graphnav.core.codec import DecodeError, codec_of, lcm_name, message_class_of
from graphnav.core.errors import CatalogError
from graphnav.core.interrupts import CtrlC
from graphnav.core.record import Event
from graphnav.watch.export.selection import Selection


class MessageTypes:
    """Converts LCM types by an adapter, else by the message class that wraps them."""

    def __init__(self, catalog: Catalog) -> None:
        self._adapters: dict[str, Adapter] = {}
        with suppress(CatalogError):
            self._adapters = dict(catalog.adapters().readers)

    def message_type(self, lcm_class: type) -> type[Message] | None:
        """Return the message class for an LCM type, None if there is none."""
        adapter = self._adapters.get(lcm_name(lcm_class))
        return adapter.message if adapter is not None else message_class_of(lcm_class)

    def message(self, lcm_class: type, fields: dict[str, Any]) -> Message | None:
        """Return the message for the fields of an LCM type, None if they cannot be converted."""
        adapter = self._adapters.get(lcm_name(lcm_class))
        wrapper = message_class_of(lcm_class)
        try:
            if adapter is not None:
                return adapter.from_lcm(fields)
            return wrapper.from_lcm_fields(fields) if wrapper is not None else None
        except CtrlC:
            raise
        except BaseException:  # noqa: BLE001 - an adapter of a plugin, and bytes of any program
            return None


class Sample(NamedTuple):
    """One message: its channel, when it was logged (microseconds), its LCM fields."""

    channel: str
    utime: int
    fields: dict[str, Any]


class Reader:
    """Reads a log once per pass; undecodable messages are left out and counted in ``undecodable``, by channel.

    ``channels``: the selected channels with installed types. ``on_time`` is called periodically with the seconds since
    the beginning of the log.
    """

    def __init__(
        self,
        recording: Recording,
        selection: Selection,
        catalog: Catalog,
        on_time: Callable[[float], None] = lambda _: None,
    ) -> None:
        self.recording = recording
        self.undecodable: Counter[str] = Counter()
        self.read: Counter[str] = Counter()
        self.on_time = on_time
        self._selection = selection
        self._types = MessageTypes(catalog)
        self._selected = selection.channels(recording)
        self.channels = tuple(name for name in self._selected if recording.channels[name] is not None)

    def at_s(self, utime: int) -> float:
        """Return the seconds from the beginning of the log to an event's timestamp."""
        return (utime - self.recording.begin_us) / 1e6

    def holds(self, event: Event) -> bool:
        """Whether an event is of a selected channel of a known type, and in the span."""
        return event.channel in self.channels and self._selection.holds(self.at_s(event.utime))

    def of(self, channel: str) -> Iterator[Sample]:
        """Yield the messages of one channel."""
        for index in range(self.recording.count(channel)):
            event = self.recording.event(channel, index)
            if self._selection.holds(self.at_s(event.utime)) and (sample := self.decoded(event)) is not None:
                yield sample

    def decoded(self, event: Event) -> Sample | None:
        """Return an event's message; None, and counted, if it cannot be decoded."""
        self.on_time(self.at_s(event.utime))
        lcm_class = self.recording.channels[event.channel]
        assert lcm_class is not None
        try:
            fields = codec_of(lcm_class).decode(event.data)
        except DecodeError:
            self.undecodable[event.channel] += 1
            return None
        self.read[event.channel] += 1
        return Sample(event.channel, event.utime, fields)

    def message_type(self, channel: str) -> type[Message] | None:
        """Return the message class of a channel, None if there is none."""
        lcm_class = self.recording.channels.get(channel)
        return None if lcm_class is None else self._types.message_type(lcm_class)

    def message(self, channel: str, fields: dict[str, Any]) -> Message | None:
        """Return the message for LCM fields, None if they cannot be converted."""
        lcm_class = self.recording.channels[channel]
        assert lcm_class is not None
        return self._types.message(lcm_class, fields)

    def losses(self) -> list[str]:
        """Return what of the selection was not exported, one sentence each."""
        damage = [*self.recording.damaged, *filter(None, [self.recording.truncated])]
        texts = [f"{self.recording.path}: {part}; left out" for part in damage]
        for name in self._selected:
            if name not in self.channels:
                n_events = self.recording.count(name)
                texts.append(f"channel {name!r}: its type is not installed; {_messages(n_events)} left out")
            elif self.undecodable[name]:
                of = self.undecodable[name] + self.read[name]
                texts.append(f"channel {name!r}: {self.undecodable[name]} of {_messages(of)} cannot be decoded")
        return texts


def _messages(count: int) -> str:
    return f"{count} message" if count == 1 else f"{count} messages"
