"""Attack graphnav: ``python tools/attack.py [KIND ...]`` spoils files by chance and reads them with its commands.

Runs are disturbed, too: by hostile messages on their group, by signals, by disks that become full, and, live, by
spoiled copies of the messages on their own channels. Plugins that the user names are trusted and not among that.

Wrong is: a traceback, an exception that escapes, a command that takes more than 10 s or 500 MB (check: 2 s and 300 MB;
what it waits for a processor does not count) or does not end, an exit status other than 0, 1 and 2, a failure without
a word, and any output that a terminal would obey.
"""

from __future__ import annotations

import argparse
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from attacks.command_process import CommandProcess
from attacks.disturbed_runs import hostile_messages, signals
from attacks.full_disks import full_disks
from attacks.live_side import live_side
from attacks.own_process import command_line, outcome_of
from attacks.spoiled_files import KINDS
from attacks.verdict import MAX_S, Outcome, faults

N_SHORT, N_LONG, N_COMMANDS = 60, 5000, 200
"""Spoiled files of each kind, and how many of them in a long attack are read by a command line of its own."""
N_LONG_OF = {"logs": 2000, "options": 2000, "python": 2000}
"""Of kinds that take longer, or are no files, in a long attack."""
MESSAGES, SIGNALS, DISKS, LIVE = "messages", "signals", "disks", "live"
COUNTS = {MESSAGES: (10_000, 1_000_000), SIGNALS: (4, 300), DISKS: (4, 120), LIVE: (1, 20)}
"""Hostile messages, runs to which signals are sent, disks that become full, and live robots, of a short and of a long
attack."""
_ALL = (*KINDS, *COUNTS)
_MAX_TOLD, _TOLD_EVERY = 5, 500


def main() -> int:
    """Attack; return 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(_ALL)} (default: all)")
    parser.add_argument("--long", action="store_true", help=f"{N_LONG} files of most kinds instead of {N_SHORT}")
    parser.add_argument("-n", type=int, help="so many files of each kind")
    parser.add_argument("--seed", type=int, default=0, help="of the first file; each has the next one (default 0)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep the files that do harm here")
    args = parser.parse_args()
    if unknown := set(args.kinds) - set(_ALL):
        parser.error(f"no kind {', '.join(sorted(unknown))}: kinds are {', '.join(_ALL)}")
    signal.signal(signal.SIGINT, signal.default_int_handler)  # background jobs ignore it, and hand that on
    n_wrong = 0
    for kind in args.kinds or _ALL:
        if kind in KINDS:
            count = args.n or (N_LONG_OF.get(kind, N_LONG) if args.long else N_SHORT)
            n_wrong += attack(kind, count, args.seed, args.keep, by_command=args.long)
        else:
            n_wrong += disturb(kind, args.n, args.seed, is_long=args.long)
    return 1 if n_wrong else 0


def attack(kind: str, count: int, seed: int, keep: Path | None, *, by_command: bool) -> int:
    """Read spoiled files of a kind; print how many were tried and how many did harm, and return the latter."""
    begin_s = time.monotonic()
    wrong: list[str] = []
    n_refused = 0
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        KINDS[kind].prepare(scratch)
        process = CommandProcess(scratch)
        for number in range(count):
            case = KINDS[kind].spoil(scratch, random.Random(f"{kind} {seed + number}"))
            outcome = _twice_if_slow(partial(process.run, case.words))
            found = faults(outcome, of_check=case.words[0] == "check")
            if by_command and number < N_COMMANDS:
                alone = _twice_if_slow(partial(outcome_of, command_line(case.words), folder=scratch))
                found += [f"as a command: {fault}" for fault in faults(alone)]
            n_refused += outcome.status != 0
            if found:
                wrong.append(f"seed {seed + number}, graphnav {' '.join(case.words)}: {'; '.join(found)}")
                if keep:
                    keep.mkdir(parents=True, exist_ok=True)
                    shutil.copy(case.file, keep / f"{kind}-{seed + number}-{case.file.name}")
            if (number + 1) % _TOLD_EVERY == 0 and number + 1 < count:
                _say(f"     {kind}: {number + 1} of {count}, {len(wrong)} did harm; {time.monotonic() - begin_s:.0f} s")
        process.close()
    _tell(f"{kind}: {count} tried, {n_refused} refused", wrong, begin_s)
    return len(wrong)


def _twice_if_slow(run: Callable[[], Outcome]) -> Outcome:
    """Return the outcome of a command, of a second time if it was slow: other programs may have had the disk."""
    outcome = run()
    return run() if outcome.elapsed_s > MAX_S else outcome


def disturb(kind: str, n: int | None, seed: int, *, is_long: bool) -> int:
    """Disturb runs from outside; print how many were tried and how many came to harm, and return the latter."""
    begin_s = time.monotonic()
    count = n or COUNTS[kind][is_long]
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        if kind == MESSAGES:
            found = list(hostile_messages(scratch, count))
        elif kind == SIGNALS:
            found = list(signals(scratch, count, seed))
        elif kind == DISKS:
            found = list(full_disks(scratch, count, seed))
        else:
            found = list(live_side(scratch, count, seed))
    what = f"{kind}: {count} sent beside {len(found)} runs" if kind == MESSAGES else f"{kind}: {len(found)} tried"
    wrong = [f"run {number}: {'; '.join(faults)}" for number, faults in enumerate(found) if faults]
    _tell(what, wrong, begin_s)
    return len(wrong)


def _tell(what: str, wrong: list[str], begin_s: float) -> None:
    _say(f"{'MISS' if wrong else 'ok  '} {what}, {len(wrong)} did harm; {time.monotonic() - begin_s:.0f} s")
    for line in wrong[:_MAX_TOLD]:
        _say(f"       {line}")
    if len(wrong) > _MAX_TOLD:
        _say(f"       and {len(wrong) - _MAX_TOLD} more")


def _say(line: str) -> None:
    sys.stdout.write(line.encode("ascii", "backslashreplace").decode() + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
