"""``graphnav record``: record LCM channels into a self-describing log."""

from __future__ import annotations

import math
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Place, UserError
from graphnav.core.cli import CommandArguments, Exit, Options, StatusLine, counted
from graphnav.core.parameters import COUNT, Parameter, command, flag
from graphnav.watch.commands.options import CHANNELS, LIVE_FEED, channels_of
from graphnav.watch.commands.quantities import size, split

if TYPE_CHECKING:
    from collections.abc import Iterator

    from graphnav.core.interrupts import Interrupt
    from graphnav.watch.recorder import Recorder

_LOOK_S = 0.1
_STATUS_S = 0.5
_EXAMPLES = """\
examples:
  graphnav record -o drive.lcmlog                        until Ctrl-C
  graphnav record -c 'robot.*' -c control.twist --for 60
  graphnav record robot.local: -o drive.lcmlog           what a robot's computer sends, every message
  graphnav record udpm://239.255.1.1:7667 --split 1GB --rotate 10 --quota 5GB

graphnav.about, the description of a run, is always recorded, as the first message, whatever the filters are.
The definitions of the types of --types are added to it, so that the log decodes alone.
lcm-logplayer and 'graphnav play' play the log. Ctrl-C, SIGTERM and SIGHUP end the recording.
"""
_MAX_ROWS = 100


@command(
    LIVE_FEED,
    Parameter(
        "path", "-o", type=Path, metavar="FILE", help="the log (default: record-DATE-TIME.lcmlog in this folder)"
    ),
    flag("force", "--force", "replace an existing file; with --split, all its parts"),
    *CHANNELS,
    Parameter(
        "split",
        "--split",
        type=split,
        metavar="SIZE|TIME",
        help="begin a new file every 100MB, 60s: FILE.0000.lcmlog, ...",
    ),
    Parameter("rotate", "--rotate", type=COUNT, metavar="N", help="keep only the newest N files; needs --split"),
    Parameter(
        "quota",
        "--quota",
        type=size,
        metavar="SIZE",
        help="end when the free space of the disk falls below this (100MB, 5GB)",
    ),
    *Options.TYPES,
    Options.FOR_S,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.codec import lcm_text_of
    from graphnav.core.interrupts import Interrupt
    from graphnav.core.lcm_url import lcm_url
    from graphnav.core.notices import print_notice
    from graphnav.watch.feed import host_of
    from graphnav.watch.recorder import buffer_notice

    types = args.load_types()
    if args.rotate is not None and args.split is None:
        raise UserError.of("only one file is written", "add --split SIZE, or remove it", Place("--rotate"))
    path = args.path or Path(f"record-{datetime.now(UTC).astimezone():%Y%m%d-%H%M%S}.lcmlog")
    is_far = args.feed is not None and host_of(args.feed) is not None
    feed = args.feed if is_far else lcm_url(("FEED", args.feed))
    if not is_far and (notice := buffer_notice(feed)):
        print_notice(notice)
    with Interrupt() as interrupt:
        recorder = _opened(args, feed, path, lcm_text_of(types.values()))
        print(f"recording to {recorder.files.paths[0]}; Ctrl-C ends it\n  from {recorder.feed_name}", flush=True)
        recorder.start()
        try:
            _watch(recorder, interrupt, args.for_s)
        finally:
            interrupt.settle()
            recorder.close()
    _print_recorded(recorder)
    has_failed = recorder.failure or (recorder.feed_failure and not recorder.statistics.n_messages)
    return Exit.FAILED if has_failed else Exit.OK


def _opened(args: CommandArguments, feed: str, path: Path, definitions: str) -> Recorder:
    """Return a recorder whose log is open; raise UserError if the file exists or cannot be written."""
    from graphnav.core.notices import print_notice
    from graphnav.core.record import LogFiles, files_of, parts_of
    from graphnav.watch.recorder import Recorder

    channels = channels_of(args)
    existing = files_of(path) if args.split is not None else [part for part in parts_of(path) if part.exists()]
    if existing and not args.force:
        hint = "name another file with -o, or replace it with --force"
        raise UserError.of(f"{existing[0]} already exists", hint, Place("-o"))
    try:
        for old in existing:
            if old != path:
                old.unlink()
        return Recorder(
            feed,
            path,
            channels,
            lambda first: LogFiles(first, args.split, args.rotate, args.quota),
            print_notice,
            definitions,
        )
    except OSError as error:
        raise UserError.of(f"cannot write {path}: {error.strerror}", "name another file", Place("-o")) from error


def _watch(recorder: Recorder, interrupt: Interrupt, for_s: float | None) -> None:
    """Show the progress until the end, or until a write fails."""
    from graphnav.core.notices import print_notice
    from graphnav.core.runner import size_text

    begin_s = shown_s = time.monotonic()
    end_s = begin_s + for_s if for_s is not None else math.inf
    shown_bytes, failure = 0, ""
    with StatusLine() as status:
        while not interrupt.asked and not recorder.failure and (left_s := end_s - time.monotonic()) > 0:
            interrupt.wait(min(left_s, _LOOK_S))
            now_s = time.monotonic()
            if now_s - shown_s < _STATUS_S:
                continue
            recorder.look()
            if recorder.feed_failure != failure and (failure := recorder.feed_failure):
                status.clear()
                print_notice(failure)
            statistics = recorder.statistics
            rate = (statistics.n_bytes - shown_bytes) / (now_s - shown_s)
            shown_s, shown_bytes = now_s, statistics.n_bytes
            status.show(
                f"{now_s - begin_s:.1f} s  {counted(statistics.n_messages, 'message')} on "
                f"{counted(len(statistics.channels), 'channel')}  "
                f"{size_text(statistics.n_bytes)}  {size_text(rate)}/s  "
                f"{'; '.join(_losses(recorder)) or 'nothing lost'}"
            )


def _losses(recorder: Recorder) -> Iterator[str]:
    """Yield the losses by cause, if there are any."""
    if lost := recorder.statistics.lost:
        left_out = min(lost, recorder.statistics.left_out)
        by_tap = (
            f", at least {left_out:,} of them left out by the tap of a run, whose own log has them" if left_out else ""
        )
        yield f"{counted(lost, 'message')} lost (missing sequence numbers){by_tap}"
    if recorder.dropped_packets:
        yield f"{counted(recorder.dropped_packets, 'packet')} dropped by the kernel"
    if recorder.feed_losses:
        yield recorder.feed_losses
    if recorder.dropped:
        yield f"{counted(recorder.dropped, 'message')} not written"
    if recorder.unnamed:
        yield f"{counted(recorder.unnamed, 'message')} on a channel without a name"


def _print_recorded(recorder: Recorder) -> None:
    """Print a table of the channels, the losses and the files."""
    from graphnav.core.errors import shown_name
    from graphnav.core.runner import size_text
    from graphnav.core.tables import Table, print_folded

    statistics = recorder.statistics
    if not statistics.n_messages:
        print(f"no message on {recorder.feed_name}{recorder.feed_failure and f': {recorder.feed_failure}'}")
    else:
        rows = []
        for name in sorted(statistics.channels)[:_MAX_ROWS]:
            channel = statistics.channels[name]
            kind = channel.kind.name if channel.kind is not None else f"unknown, {channel.fingerprint.hex()}"
            lost = f"{channel.lost:,}" if channel.lost is not None else ""
            rows.append((shown_name(name), kind, f"{channel.count:,}", size_text(channel.n_bytes), lost))
        print_folded(Table.plain(("channel", "type", "messages", "size", "lost"), rows))
        if (n_more := len(statistics.channels) - _MAX_ROWS) > 0:
            print(f"and {counted(n_more, 'more channel')}")
        if statistics.others.count:
            print(f"and {counted(statistics.others.count, 'message')} on further channels")
    said = "; ".join(_losses(recorder)) or "nothing lost"
    print(f"{counted(statistics.n_messages, 'message')}, {size_text(statistics.n_bytes)}; {said}")
    files = recorder.files.paths
    names = str(files[0]) if len(files) == 1 else f"{files[0]} to {files[-1].name} ({len(files)} files)"
    print(f"{names}: {size_text(sum(file.stat().st_size for file in files if file.exists()))}")
