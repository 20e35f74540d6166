"""``graphnav merge``: the logs of several computers as one, on one time line."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from graphnav import Place, UserError
from graphnav.core.cli import CommandArguments, Exit, Options, counted
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, flag, many

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from graphnav.watch.merge import Merged, MergedLog, NamedLog

_NAME = re.compile(r"[A-Za-z0-9_-]+")
_MAX_OFFSET_S = 1e10
_EXAMPLES = """\
examples:
  graphnav merge robot=runs/a laptop=runs/b -o both.lcmlog
  graphnav merge a.lcmlog b.lcmlog -o both.lcmlog --sent a:CAMERA --sent b:BASE_CMD
  graphnav merge a.lcmlog b.lcmlog -o both.lcmlog --offset 3600.25

The first log keeps timestamps, channels and order, and replays as before. The clocks of the others are measured from
messages that two logs hold: those that went from one host to the other, and back.
"""


class _Offset(NamedTuple):
    """Seconds of ``--offset``, and the log's name, empty for the second log."""

    name: str
    ahead_s: float


def _offset(text: str) -> _Offset:
    name, _, number = text.rpartition(":")
    try:
        ahead_s = float(number)
    except ValueError:
        ahead_s = float("nan")
    if abs(ahead_s) <= _MAX_OFFSET_S:
        return _Offset(name, ahead_s)
    raise argparse.ArgumentTypeError(f"'{text}' is not an offset: write SECONDS, or LOG:SECONDS")


def _sent(text: str) -> tuple[str, str]:
    name, colon, channel = text.partition(":")
    if name and colon and channel:
        return name, channel
    raise argparse.ArgumentTypeError(f"'{text}' names no channel of a log: write LOG:CHANNEL")


@command(
    Options.LOG.but(
        name="logs",
        metavar="[NAME=]LOG",
        nargs="+",
        type=str,
        help="a log or a run folder; NAME is put before those of its channels whose names are taken "
        "(default: the name of the folder or the file)",
    ),
    Parameter("target", "-o", type=Path, metavar="FILE", required=True, help="the merged log"),
    many(
        "offsets",
        "--offset",
        type=_offset,
        metavar="[NAME:]SECONDS",
        help="by how much a log's clock is ahead of the first one's, in place of a measurement; without NAME that of "
        "the second log",
    ),
    many(
        "sent",
        "--sent",
        type=_sent,
        metavar="NAME:CHANNEL",
        help="the log's host sent this channel; for logs of loggers, which do not tell it",
    ),
    flag("once", "--once", "of a message that several logs hold on a channel of one name write only the first copy"),
    flag("force", "--force", "replace an existing file"),
    Options.JSON,
    *Options.TYPES,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.cli import progress_bar
    from graphnav.core.machine import Console
    from graphnav.watch.merge import merge_logs

    args.load_types()
    with progress_bar(Console(stderr=True), "merge", None) as show:
        merged = merge_logs(
            _named(args),
            args.target,
            once=args.once,
            force=args.force,
            on_time=lambda at_s, _: show(round(at_s * 1e6)),
        )
    for notice in merged.notices:
        print_notice(notice)
    if args.json:
        print(json.dumps(_as_json(merged)))
    else:
        _print(merged)
    return Exit.OK


def _named(args: CommandArguments) -> list[NamedLog]:
    """Return the logs as given; raise UserError for one that does not exist, and for names of none."""
    from graphnav.core.record import find_log
    from graphnav.core.run_folder import RunFolder
    from graphnav.watch.merge import NamedLog

    if len(args.logs) < 2:
        raise UserError.of("only one log is given", "name at least two", Place("merge"))
    logs: list[NamedLog] = []
    for word in args.logs:
        name, equals, rest = word.partition("=")
        is_named = equals and _NAME.fullmatch(name) and not Path(word).exists()
        path = find_log(Path(rest if is_named else word))
        folder = path.resolve().parent.name if path.name == RunFolder.LOG else path.stem
        logs.append(NamedLog(name if is_named else "-".join(_NAME.findall(folder)) or "log", path))
    names = [log.name for log in logs]
    for name in [*(offset.name for offset in args.offsets if offset.name), *(name for name, _ in args.sent)]:
        if name not in names:
            raise UserError.of(f"no log has the name '{name}'", f"names are {', '.join(names)}", Place("merge"))
    ahead_us = {offset.name or names[1]: round(offset.ahead_s * 1e6) for offset in args.offsets}
    if names[0] in ahead_us:
        what = "the clock of the first log is the one that counts"
        raise UserError.of(what, "give the offsets of the others", Place("--offset"))
    return [
        log._replace(
            ahead_us=ahead_us.get(log.name), sent=frozenset(channel for name, channel in args.sent if name == log.name)
        )
        for log in logs
    ]


def _print(merged: Merged) -> None:
    from graphnav.core.runner import size_text
    from graphnav.core.tables import Table, print_folded

    first, *others = merged.logs
    print(
        f"{merged.path}: {size_text(merged.n_bytes)}, {merged.n_messages:,} messages of {len(merged.logs)} logs, "
        f"{merged.duration_us / 1e6:.3f} s by the clock of {first.name}"
    )
    for log in others:
        print("\n".join(_lines(log, first.name)))
    rows = [row for log in others for row in _way_rows(log)]
    if rows:
        print_folded(Table.plain(("channel", "and", "sent by", "messages", "min", "median", "max"), rows))


def _way_rows(log: MergedLog) -> Iterator[tuple[str, ...]]:
    import numpy as np

    from graphnav.core.errors import shown_name

    for way in log.ways:
        assert log.measured_by is not None, "it shares messages with that log"
        sender = {1: log.measured_by, -1: log.name, 0: "?"}[way.way]
        ends = f"{log.measured_by}  {shown_name(way.channel)}", f"{log.name}  {shown_name(way.other_channel)}"
        took_ms = [f"{value / 1e3:.1f} ms" for value in np.quantile(way.took_us, (0.0, 0.5, 1.0))]
        yield *ends, sender, f"{len(way.took_us):,}", *took_ms


def _lines(log: MergedLog, first: str) -> Iterator[str]:
    """Yield what is known of a log's clock, and its channels with new names."""
    from graphnav.core.machine import side_text

    offset = log.offset
    far = f"{abs(log.ahead_us) / 1e6:.6f} s {side_text(log.ahead_us)}"
    words = [f"{log.name}: its clock is {far} that of {first}", *_error(log)]
    if offset.drift_error is not None and not offset.drift:
        words.append(f"drift below {offset.drift_error * 1e6:.1f} ppm")
    elif offset.drift_error is not None:
        words.append(f"drift {offset.drift * 1e6:+.1f} ppm, give or take {offset.drift_error * 1e6:.1f}")
    elif offset.drift:
        words.append(f"drift {offset.drift * 1e6:+.1f} ppm")
    yield ", ".join(words)
    if log.measured_by is not None:
        n = [f"{counted(offset.n_there, 'message')} from {log.measured_by}", f"{offset.n_back:,} back"]
        n += [f"{offset.n_unknown:,} of unknown direction"] if offset.n_unknown else []
        yield f"  measured from {', '.join(n)}"
    for one in offset.sets:
        yield f"  a clock was set at {one.at_us / 1e6:.6f} s of {log.name}: by {one.by_us / 1e6:+.6f} s"
    if log.n_left_out:
        yield f"  {counted(log.n_left_out, 'message')} that an earlier log holds on the same channel left out"
    if log.names:
        yield f"  {counted(len(log.names), 'channel')} with its name before their own: {_few(list(log.names.values()))}"


def _error(log: MergedLog) -> Iterator[str]:
    offset = log.offset
    if log.measured_by is None:
        yield "as given"
    elif offset.error_us is not None:
        yield f"give or take {offset.error_us / 1e3:.2f} ms"
    elif offset.n_there and not offset.n_back:
        yield "or less by the shortest delay of a message: none went back"
    elif offset.n_back and not offset.n_there:
        yield "or more by the shortest delay of a message: they went one way only"
    else:
        yield "give or take the delay of a message: the logs do not tell who sent them (see --sent)"


def _few(names: Sequence[str], n_shown: int = 6) -> str:
    from graphnav.core.errors import shown_name

    more = f" and {len(names) - n_shown} more" if len(names) > n_shown else ""
    return ", ".join(map(shown_name, names[:n_shown])) + more


def _as_json(merged: Merged) -> dict[str, Any]:
    return {
        "log": str(merged.path),
        "bytes": merged.n_bytes,
        "messages": merged.n_messages,
        "duration_s": merged.duration_us / 1e6,
        "logs": [_log_as_json(log) for log in merged.logs],
        "notices": list(merged.notices),
    }


def _log_as_json(log: MergedLog) -> dict[str, Any]:
    import numpy as np

    offset = log.offset
    return {
        "name": log.name,
        "log": str(log.path),
        "ahead_us": log.ahead_us,
        "error_us": offset.error_us,
        "drift_ppm": offset.drift * 1e6,
        "drift_error_ppm": None if offset.drift_error is None else offset.drift_error * 1e6,
        "set": [{"at_us": one.at_us, "by_us": one.by_us} for one in offset.sets],
        "measured_by": log.measured_by,
        "from_there": offset.n_there,
        "back": offset.n_back,
        "unknown": offset.n_unknown,
        "renamed": dict(log.names),
        "left_out": log.n_left_out,
        "ways": [
            {
                "channel": way.channel,
                "other_channel": way.other_channel,
                "sender": {1: log.measured_by, -1: log.name, 0: None}[way.way],
                "messages": len(way.took_us),
                **dict(
                    zip(("min_us", "median_us", "max_us"), np.quantile(way.took_us, (0, 0.5, 1)).tolist(), strict=True)
                ),
            }
            for way in log.ways
        ],
    }
