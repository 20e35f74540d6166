"""Read logs by channel and time, as messages, arrays or tables."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles, Longs
from graphnav.core.api.arguments import Argument, PathLike, seconds_of, wrong_type
from graphnav.core.api.logs.log_channel import LogChannel, Sample, log_html
from graphnav.core.api.logs.open_completed import open_completed
from graphnav.core.api.logs.stack import Stack, stacked, table_of
from graphnav.core.api.notices import tell
from graphnav.core.catalog import Catalog
from graphnav.core.codec import lcm_name, message_class_of
from graphnav.core.errors import LogError, UserError, did_you_mean, shown_name
from graphnav.core.parameters import Parameter
from graphnav.core.record import Recording, find_log
from graphnav.core.trust import Trust

if TYPE_CHECKING:
    import pandas as pd


_PATH = Parameter("path", example='"runs/1"')
_MAX_NAMES = 40


def open_log(path: PathLike, *, trust: bool = False) -> Log:
    """Open the log of a run folder, or a log file of graphnav, lcm-logger or any other LCM program.

    ``path``: the folder or the file. A damaged log can be opened too: complete messages can be read, and `Log.damage`
    lists the losses. What a log with ``record: replayable`` leaves out, the default of lockstep runs, a replay makes
    again; that is logged as a warning, as is why it cannot. ``trust``: run the plugin files of the run folder for it;
    otherwise only those that graphnav wrote run.

    Raises
    ------
    UserError
        The file does not exist.
    LogError
        The file cannot be read, or is not an LCM log.
    """
    name = Argument(path, _PATH).path()
    try:
        return Log(open_completed(find_log(name), Catalog(Trust(runs_all=trust)), tell=tell))
    except OSError as error:
        raise UserError.of(f"cannot read {name}: {error.strerror}", "name a run folder or a log") from error


class Log:
    """The messages of a log; every method reads them from the file when called.

    Times are seconds from the start of the log. In the log of a run the time of a message is its stamp, which all
    messages derived from one frame share; in other logs it is the time of recording.

    A message that cannot be decoded is skipped, logged as a warning and listed in ``damage``. A context manager that
    closes the file on exit. May be read from several threads.
    """

    def __init__(self, recording: Recording, keeps: object = None) -> None:
        """Read ``recording``; ``keeps`` is an object to keep alive as long as this one."""
        self._recording = recording
        self._keeps = keeps
        self._is_closed = False
        self._stamps: dict[str, Longs] = {}
        self._undecodable: dict[str, dict[int, str]] = {}

    @property
    def path(self) -> Path:
        """The path of the log."""
        return self._recording.path

    @property
    def damage(self) -> tuple[str, ...]:
        """Lost data: bytes that are not events, a truncated end, and messages that could not be decoded so far."""
        truncated = self._recording.truncated
        lost = [*map(str, self._recording.damaged), *([f"truncated: {truncated}"] if truncated else [])]
        for channel, errors in self._undecodable.items():
            n_all = self._recording.count(channel)
            what = f"{len(errors)} of {n_all} messages of '{shown_name(channel)}' cannot be decoded"
            lost.append(f"{what}: {shown_name(min(errors.items())[1])}")
        return tuple(lost)

    @cached_property
    def channels(self) -> Mapping[str, LogChannel]:
        """The channels, in the order of their first messages."""
        return MappingProxyType({name: self._channel(name) for name in self._recording.channels})

    @property
    def duration_s(self) -> float:
        """The time of the last message."""
        return max((channel.last_s for channel in self.channels.values()), default=0.0)

    @property
    def graph(self) -> Mapping[str, Any]:
        """The resolved graph of the run as YAML data; raises LogError if the log does not contain it."""
        return self._recording.graph

    def messages(self, channel: str, *, start_s: float | None = None, end_s: float | None = None) -> Iterator[Sample]:
        """Return the messages of a channel with ``start_s <= time_s < end_s``, oldest first, one at a time.

        Raises
        ------
        UserError
            The channel does not exist, its type is not installed, or a time is not a number.
        """
        indices = self._within(channel, start_s, end_s)
        return self._samples(channel, indices)

    def at(self, channel: str, time_s: float) -> Any:
        """Return the newest message of a channel at ``time_s``, as a sampled input would see it.

        Raises
        ------
        UserError
            As `messages`, or there is no message yet.
        """
        at_us = seconds_of(time_s, "time_s")
        if at_us is None:
            raise wrong_type("time_s", time_s, "a number of seconds", "write time_s=1.5")
        stamps = self._readable_us(channel)
        earlier = np.flatnonzero(stamps <= at_us)
        for index in earlier[np.argsort(stamps[earlier], kind="stable")][::-1]:
            if (found := self._message(channel, int(index))) is not None:
                return found
        first_s = self.channels[channel].first_s
        what = f"'{shown_name(channel)}' has no message at {time_s:g} s"
        raise UserError.of(what, f"its first one is at {first_s:g} s" if stamps.size and not earlier.size else "")

    def times_s(self, channel: str) -> Doubles:
        """Return the times of all messages of a channel, float64 (n,); raises UserError as `messages`."""
        return self._times_us(channel) / 1e6

    def stack(self, channel: str, field: str, *, start_s: float | None = None, end_s: float | None = None) -> Stack:
        """Return one field of many messages as one array: ``times_s, uv_px = log.stack("flow.flow", "uv_px")``.

        The array has the messages first: (n, rows, cols, 2) for a flow, (n,) for a number. It is a copy.

        Raises
        ------
        UserError
            As `messages`; the field does not exist, is not numeric, or changes its shape.
        """
        indices = self._within(channel, start_s, end_s)
        if not isinstance(field, str):
            raise wrong_type("field", field, "a string", 'write field="uv_px"')
        return stacked(self._samples(channel, indices), len(indices), channel, field)

    def to_pandas(self, channel: str, *, start_s: float | None = None, end_s: float | None = None) -> pd.DataFrame:
        """Return a table of a channel: one row per message, ``time_s`` as index, one column per scalar field.

        Arrays of at most 16 elements, of the same shape in all messages, become columns ``field[0]``, ``field[1]``;
        nested structs ``field.name``; lists of strings are kept. Larger arrays are omitted: use `stack`.

        Raises
        ------
        UserError
            As `messages`, or pandas is not installed.
        """
        return table_of(self._samples(channel, self._within(channel, start_s, end_s)))

    def close(self) -> None:
        """Close the file."""
        self._is_closed = True
        self._recording.close()
        self._keeps = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<graphnav.Log {self.path}: {len(self.channels)} channels, {self.duration_s:.1f} s>"

    def _repr_html_(self) -> str:
        return log_html(self.path, self.channels.values(), self.damage)

    @cached_property
    def _is_of_run(self) -> bool:
        """Whether a run wrote the log: then stamps count from its start. A logger records stamps of many clocks."""
        about = self._recording.about
        return about is not None and not about.run_id

    def _channel(self, name: str) -> LogChannel:
        lcm_class = self._recording.channels[name]
        stamps = self._times_us(name) / 1e6
        return LogChannel(
            name=name,
            type_name=lcm_name(lcm_class) if lcm_class else "",
            message=message_class_of(lcm_class) if lcm_class else None,
            n_messages=stamps.size,
            first_s=float(stamps.min()),
            last_s=float(stamps.max()),
        )

    def _times_us(self, channel: str) -> Longs:
        """Return the times of a channel's messages, microseconds from the start of the log."""
        self._check_channel(channel)
        if channel not in self._stamps:
            recording = self._recording
            stamps = recording.utimes(channel) if self._is_of_run else recording.event_utimes(channel)
            self._stamps[channel] = np.array(stamps, np.int64) - recording.begin_us
        return self._stamps[channel]

    def _readable_us(self, channel: str) -> Longs:
        """Return the times of a channel's messages; raise UserError if they cannot be decoded at all."""
        stamps = self._times_us(channel)
        if self._recording.channels[channel] is None:
            what = f"the type of channel '{shown_name(channel)}' is not installed"
            raise UserError.of(what, "install the package generated by lcm-gen, and import it")
        return stamps

    def _check_channel(self, channel: object) -> None:
        if self._is_closed:
            raise UserError.of(f"{self.path} is closed", "open it again with graphnav.open_log")
        known = self._recording.channels
        if not isinstance(channel, str):
            raise wrong_type("channel", channel, "a string", 'write channel="control.twist"')
        if channel not in known:
            names = [shown_name(name) for name in known]
            more = f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else ""
            listed = f"it has {', '.join(names[:_MAX_NAMES])}{more}" if names else "it is empty"
            what = f"{self.path} has no channel '{shown_name(channel)}'"
            raise UserError.of(what, did_you_mean(channel, names) or listed)

    def _within(self, channel: str, start_s: float | None, end_s: float | None) -> npt.NDArray[np.intp]:
        """Return the indices of a channel's messages between two times."""
        start_us, end_us = seconds_of(start_s, "start_s"), seconds_of(end_s, "end_s")
        stamps = self._readable_us(channel)
        is_within = np.ones(stamps.size, bool)
        if start_us is not None:
            is_within &= stamps >= start_us
        if end_us is not None:
            is_within &= stamps < end_us
        return np.flatnonzero(is_within)

    def _samples(self, channel: str, indices: npt.NDArray[np.intp]) -> Iterator[Sample]:
        times_us = self._times_us(channel)
        for index in indices.tolist():
            if (found := self._message(channel, index)) is not None:
                yield Sample(float(times_us[index] / 1e6), found)

    def _message(self, channel: str, index: int) -> Any:
        """Return a message, None if it cannot be decoded."""
        lcm_class = self._recording.channels[channel]
        try:
            if lcm_class and message_class_of(lcm_class):
                return self._recording.message(channel, index)[2]
            return self._recording.fields(channel, index)
        except LogError as error:
            said = str(error)
            errors = self._undecodable.setdefault(channel, {})
            if not errors:
                logging.getLogger("graphnav").warning("%s; it is skipped and counted in Log.damage", shown_name(said))
            errors[index] = said
            return None
        except OSError as error:
            raise LogError(f"{self.path}: {error.strerror}") from error
