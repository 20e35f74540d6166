"""Merge logs: measure their clocks, name their channels, and write their events in the order of time."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphnav import About, GraphnavError, Recording, Status, UserError
from graphnav.core.errors import LogError, shown_name
from graphnav.core.record import LogWriter, parts_of
from graphnav.core.spec import option_in
from graphnav.watch.export.files import placed_file
from graphnav.watch.merge.channel_names import described, renamed_channels, run_of, taken_names
from graphnav.watch.merge.clock_offset import ClockOffset, measure
from graphnav.watch.merge.shared_messages import Found, LogMessages, Way, find_shared

_SHOW_EVERY = 1000
_MAX_NAME = 63
"""Characters of a channel's name that LCM sends."""


class NamedLog(NamedTuple):
    """A log to merge.

    ``name``: before its channels whose names are taken. ``ahead_us``: by how much its clock is ahead of the first
    log's, None to measure it. ``sent``: channels whose messages are known to come from its host.
    """

    name: str
    path: Path
    ahead_us: int | None = None
    sent: Collection[str] = ()


@dataclass(frozen=True)
class MergedLog:
    """The place of one log in the merged one.

    ``measured_by``: the log whose messages gave its offset, None for the first and one that was given. ``n_left_out``:
    messages that an earlier log holds on the same channel. ``ways``: the messages that it shares with that log.
    """

    name: str
    path: Path
    offset: ClockOffset
    ahead_us: int
    """The offset at its first event."""
    measured_by: str | None
    names: Mapping[str, str]
    """New names of channels by the old ones."""
    ways: Sequence[Way] = ()
    n_left_out: int = 0


@dataclass(frozen=True)
class Merged:
    """The merged log, and its parts in the order that they were given; ``notices``: a sentence for each problem."""

    path: Path
    n_messages: int
    n_bytes: int
    duration_us: int
    logs: Sequence[MergedLog]
    notices: Sequence[str] = ()


@dataclass
class _Part:
    """A log on its way into the merged one."""

    given: NamedLog
    log: LogMessages
    offset: ClockOffset
    reference: _Part | None = None
    found: Found | None = None
    names: dict[str, str] = field(default_factory=dict)
    kept: NDArray[np.bool_] | None = None
    """Which events are written, None for all."""

    @property
    def run_id(self) -> str:
        """The id of the run that wrote the log; the log's name if it is not known."""
        return self.log.own_id or self.given.name


def merge_logs(
    given: Sequence[NamedLog],
    target: Path,
    *,
    once: bool = False,
    force: bool = False,
    on_time: Callable[[float, float], None] = lambda _at_s, _of_s: None,
) -> Merged:
    """Write the events of all logs to ``target``, in the order of time by the clock of the first one.

    Its events keep their timestamps, channels and order, so that it replays as before. The others' timestamps are
    moved by the offsets of their clocks, measured from the messages that logs share. ``once``: of messages that an
    earlier log holds on a channel of the same name only its copy is written. ``on_time`` is called with the progress,
    seconds of the merged log.

    Raises
    ------
    UserError
        Logs are given twice, hold simulated time, or share no messages; ``target`` is one of them or exists.
    GraphnavError
        A log cannot be read, or writing fails; nothing is left behind.
    """
    _refuse_unusable(given, target)
    with ExitStack() as opened:
        logs = [LogMessages(opened.enter_context(Recording(one.path)), one.sent) for one in given]
        _refuse_simulated(given, logs)
        _refuse_equal(given, logs)
        parts = _placed(given, logs)
        _name(parts, once=once)
        with placed_file(target, target.suffix or ".lcmlog", source=given[0].path, force=force) as aside:
            n_messages, duration_us = _write(parts, target, aside, on_time)
            n_bytes = aside.stat().st_size
        return Merged(target, n_messages, n_bytes, duration_us, [_merged(part) for part in parts], _notices(parts))


def _refuse_unusable(given: Sequence[NamedLog], target: Path) -> None:
    files: dict[tuple[int, int], Path] = {}
    for one in given:
        for file in filter(Path.exists, parts_of(one.path)):
            stat = file.stat()
            if (before := files.setdefault((stat.st_dev, stat.st_ino), one.path)) != one.path or given.count(one) > 1:
                raise UserError.of(f"{one.path} and {before} are the same log", "name each log once")
    if target.exists() and (target.stat().st_dev, target.stat().st_ino) in files:
        raise UserError.of(f"{target} is one of the logs to merge", "choose another name with -o")
    counts = Counter(one.name for one in given)
    if twice := next((one for one in given if counts[one.name] > 1), None):
        what = f"two logs have the name '{twice.name}'"
        raise UserError.of(what, f"name one: {twice.name}2={twice.path}")


def _refuse_simulated(given: Sequence[NamedLog], logs: Sequence[LogMessages]) -> None:
    for one, log in zip(given, logs, strict=True):
        about = log.recording.about
        if about is not None and not about.run_id and about.channels and Status.CHANNEL not in about.channels:
            what = f"{one.path} holds simulated time, which no clock of another log is related to"
            raise UserError.of(what, "merge logs of live runs, or of loggers")


def _refuse_equal(given: Sequence[NamedLog], logs: Sequence[LogMessages]) -> None:
    for place, log in enumerate(logs):
        for before, other in zip(given, logs[:place], strict=False):
            if np.array_equal(log.logged_us, other.logged_us) and np.array_equal(log.digests, other.digests):
                raise UserError.of(f"{given[place].path} and {before.path} hold the same events", "name each log once")


def _placed(given: Sequence[NamedLog], logs: Sequence[LogMessages]) -> list[_Part]:
    """Return the logs with their offsets, in the order given: each measured by the log that tells it best."""
    placed: dict[int, _Part] = {0: _Part(given[0], logs[0], ClockOffset.given(0))}
    for place in range(1, len(given)):
        if (ahead_us := given[place].ahead_us) is not None:
            placed[place] = _moved(_Part(given[place], logs[place], ClockOffset.given(ahead_us)))
    while len(placed) < len(given):
        best: tuple[float, int, _Part] | None = None
        for place in (place for place in range(len(given)) if place not in placed):
            for part in placed.values():
                if (found := find_shared(part.log, logs[place])) is None:
                    continue
                offset = _measured(found, given[place], logs[place], part)
                error_us = np.inf if offset.error_us is None else offset.error_us
                if best is None or error_us < best[0]:
                    best = error_us, place, _Part(given[place], logs[place], offset, part, found)
        if best is None:
            _refuse_unshared(given, placed)
        else:
            placed[best[1]] = _moved(best[2])
    return [placed[place] for place in range(len(given))]


def _measured(found: Found, given: NamedLog, log: LogMessages, by: _Part) -> ClockOffset:
    try:
        offset = measure(found.messages, log.at_us)
    except GraphnavError as error:
        hint = f"give its offset: --offset {given.name}:SECONDS"
        raise UserError.of(f"{given.path} and {by.given.path}: {error}", hint) from error
    if offset.error_us is None or by.offset.error_us is None:
        return offset._replace(error_us=None)
    return offset._replace(error_us=offset.error_us + by.offset.error_us)


def _refuse_unshared(given: Sequence[NamedLog], placed: Collection[int]) -> None:
    missing = next(one for place, one in enumerate(given) if place not in placed)
    what = f"{missing.path} shares no message with the other logs, so that its clock cannot be measured"
    hint = (
        f"record what both send and receive in both logs, or give by how much its clock is ahead of "
        f"{given[0].name}'s: --offset {missing.name}:SECONDS"
    )
    raise UserError.of(what, hint)


def _moved(part: _Part) -> _Part:
    """Set the times of a log by the first log's clock."""
    ahead_us = part.offset.stretches[0].ahead_us
    if not abs(ahead_us) < 1 << 62:
        raise UserError.of(f"the clock of {part.given.path} is {ahead_us:.0f} us ahead", "give an offset that can be")
    part.log.first_us = part.offset.to_first(part.log.at_us)
    if part.log.first_us.min() < 0:
        what = f"by the clock of the first log {part.given.path} begins before 1970"
        raise UserError.of(what, f"give its offset: --offset {part.given.name}:SECONDS")
    part.log.first_us = np.maximum.accumulate(part.log.first_us)
    return part


def _name(parts: Sequence[_Part], *, once: bool) -> None:
    """Give the channels of later logs names that are free, and find the messages that earlier logs hold."""
    taken = set(taken_names(parts[0].log, {}))
    for place, part in enumerate(parts[1:], 1):
        same = _same(parts[:place], part) if once else {}
        part.names = renamed_channels(part.log, part.given.name, taken, same)
        part.kept = _kept(part, same) if same else None
        taken.update(taken_names(part.log, part.names))


def _same(before: Sequence[_Part], part: _Part) -> dict[str, Counter[int]]:
    """Return how often earlier logs hold each message, by the channels of the same name that share some."""
    found: dict[str, Counter[int]] = {}
    for channel in part.log.channels:
        held = Counter[int]()
        for one in before:
            if channel in one.log.channels and channel not in one.names:
                held |= Counter(one.log.digests_of(channel).tolist())
        if channel != About.CHANNEL and not held.keys().isdisjoint(part.log.digests_of(channel).tolist()):
            found[channel] = held
    return found


def _kept(part: _Part, same: Mapping[str, Counter[int]]) -> NDArray[np.bool_]:
    kept = np.ones(len(part.log.at_us), np.bool_)
    for channel, held in same.items():
        for number in part.log.recording.index.channels[channel]:
            digest = int(part.log.digests[number])
            if held[digest] > 0:
                held[digest] -= 1
                kept[number] = False
    return kept


class _Next(NamedTuple):
    """An event that is due: its time by the first log's clock, the log's place, its number there."""

    at_us: int
    place: int
    number: int


def _events(part: _Part, place: int) -> Iterator[_Next]:
    for number in range(len(part.log.at_us)):
        if part.kept is None or part.kept[number]:
            yield _Next(int(part.log.first_us[number]), place, number)


class _Descriptions:
    """The messages that are written in place of ``graphnav.about`` of each log."""

    def __init__(self, parts: Sequence[_Part]) -> None:
        self._parts = parts
        ids = [part.log.run_ids | {part.run_id} for part in parts]
        self._told = [frozenset[str]().union(*ids[:place]) for place in range(len(parts))]
        """The runs that earlier logs tell of, by log."""
        self.first = next((place for place, part in enumerate(parts) if part.log.recording.count(About.CHANNEL)), None)
        """The log whose description begins the merged one, None without any."""

    def begin(self) -> bytes:
        """Return the description that begins the merged log."""
        assert self.first is not None
        part = self._parts[self.first]
        return described(part.log.recording.event(About.CHANNEL, 0).data, part.run_id, part.names)

    def of(self, due: _Next, data: bytes) -> bytes | None:
        """Return what is written at this place, None for nothing: it began the log, or an earlier log tells it."""
        part = self._parts[due.place]
        if due.place == self.first and due.number == part.log.recording.index.channels[About.CHANNEL][0]:
            return None
        about = described(data, part.run_id, part.names)
        return None if run_of(about) in self._told[due.place] else about


def _write(
    parts: Sequence[_Part], target: Path, aside: Path, on_time: Callable[[float, float], None]
) -> tuple[int, int]:
    """Write all events; return how many, and how long they last."""
    begin_us = min(int(part.log.first_us[0]) for part in parts)
    end_us = max(int(part.log.first_us[-1]) for part in parts)
    descriptions = _Descriptions(parts)
    try:
        with LogWriter(aside) as log:
            if descriptions.first is not None:
                log.write(About.CHANNEL, begin_us, descriptions.begin())
            for due in heapq.merge(*(_events(part, place) for place, part in enumerate(parts))):
                part = parts[due.place]
                channel, utime, data = part.log.recording.at(due.number)
                if channel == About.CHANNEL:
                    if (about := descriptions.of(due, data)) is None:
                        continue
                    data = about
                log.write(part.names.get(channel, channel), utime if due.place == 0 else due.at_us, data)
                if log.n_events % _SHOW_EVERY == 0:
                    on_time((due.at_us - begin_us) / 1e6, (end_us - begin_us) / 1e6)
        return log.n_events, end_us - begin_us
    except LogError as error:
        if isinstance(cause := error.__cause__, OSError):
            what = f"cannot write {target}: {cause.strerror}\n  make room, or choose another place with -o"
            raise GraphnavError(what) from error
        raise


def _merged(part: _Part) -> MergedLog:
    by = part.reference
    return MergedLog(
        name=part.given.name,
        path=part.given.path,
        offset=part.offset,
        ahead_us=int(part.log.at_us[0] - part.log.first_us[0]),
        measured_by=None if by is None else by.given.name,
        names=part.names,
        ways=() if by is None or part.found is None else part.found.ways(by.log, part.log),
        n_left_out=0 if part.kept is None else int((~part.kept).sum()),
    )


def _notices(parts: Sequence[_Part]) -> list[str]:
    notices = [notice for part in parts if (notice := part.log.recording.damage_notice())]
    notices += [notice for part in parts if (notice := _left_out(part))]
    first, *others = parts
    if first.log.recording.timeline.n_jumps:
        notices.append(
            f"{first.given.path}: its timestamps jump, and the others follow them as they were before; "
            "name a log first whose clock was not set"
        )
    notices += [
        f"{part.given.path}: its timestamps jump: its clock was set back, or they are damaged; they are corrected"
        for part in others
        if part.log.recording.timeline.n_jumps
    ]
    for part in others:
        longest = max(part.names.values(), key=len, default="")
        if len(longest) > _MAX_NAME:
            notices.append(
                f"'{shown_name(longest)}' is too long for a channel of LCM: give {part.given.name} a shorter name"
            )
    return notices


def _left_out(part: _Part) -> str:
    """Return that the log of a run does not hold large messages, an empty string if it does."""
    recording = part.log.recording
    if recording.about is None or recording.about.run_id:
        return ""  # a logger's
    try:
        options = recording.graph.get("run")
    except LogError:
        return ""
    option = (option_in(options.get("record")) if isinstance(options, dict) else None) or "small"
    if option == "all":
        return ""
    kept = "those of inputs and sources" if option == "replayable" else "the first of each channel"
    return (
        f"{part.given.path} keeps of messages from {Recording.SMALL_BYTES} bytes on only {kept} (record: {option})\n"
        "  to follow pictures from one host to the other, run with --set run.record=all"
    )
