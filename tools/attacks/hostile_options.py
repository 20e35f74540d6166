"""Command lines of every command that ends by itself, with hostile values of its options."""

from __future__ import annotations

import argparse
import os
import random
from collections.abc import Iterator
from functools import cache

from attacks.spoil import hostile
from graphnav.core.cli import command_called

_LOG = "good"
_BRIEF = ("--for", "0.3")
_GOOD = {
    "bw": _BRIEF,
    "check": ("corridor_ccw",),
    "completion": ("bash",),
    "doctor": (),
    "draw": ("corridor_ccw",),
    "echo": ("robot.image", *_BRIEF),
    "export": (_LOG,),
    "figure": (_LOG,),
    "hz": _BRIEF,
    "info": (_LOG,),
    "new-stage": ("family.stage",),
    "play": (_LOG,),
    "pub": ("channel", "Twist"),
    "record": (*_BRIEF, "-o", "recorded.lcmlog"),
    "replay": (_LOG,),
    "run": ("corridor_ccw", "--until", "0.2", "--no-tap", "--no-pictures"),
    "schema": (),
    "spy": ("--json", *_BRIEF),
    "stages": (),
    "top": ("--once", *_BRIEF),
    "types": (),
}
"""Words of each command with which it does what it is for; the log ``good`` is in the working folder."""
_WAITS = {"--for", "--pace", "--speed", "--start", "--every", "--rate", "--until", "--loop", "--live"}
"""Options that may rightly make a command last: of them only what cannot be a time is tried."""
_PLAUSIBLE = (
    *("seed", "flow=plane.ica", "robot.rate_hz=nan", "flow.x=[1", "run.until_s=-3", "0:2", "5:1", "1e3", "a=b=c", "."),
    *("udpm://", "udpm://1.2.3.4:99999?ttl=300", "csv", "mcap", "robot.*", "[", "(", "--", "-1", "good/summary.json"),
)
_NO_TIMES = ("nan", "-inf", "-1", "0", "abc", "2min3", "--", "")


def hostile_words(drawn: random.Random) -> list[str]:
    """Return a command line in which some options, now and then what it is about, have hostile values."""
    command = drawn.choice(sorted(_GOOD))
    words = list(_GOOD[command])
    if words and not words[0].startswith("-") and drawn.random() < 0.2:
        words[0] = _word(drawn)
    options = _options_of(command)
    for option in drawn.sample(options, min(len(options), drawn.randint(1, 3))):
        words += _given(option, drawn)
    return [command, *words]


def _given(option: argparse.Action, drawn: random.Random) -> Iterator[str]:
    """Yield the words that give an option a value."""
    name = drawn.choice(option.option_strings)
    waits = not _WAITS.isdisjoint(option.option_strings)
    if option.nargs == 0:
        yield from () if waits else (name,)
        return
    value = drawn.choice(_NO_TIMES) if waits else _word(drawn)
    yield from (f"{name}={value}",) if name.startswith("--") and drawn.random() < 0.5 else (name, value)


def _word(drawn: random.Random) -> str:
    """Return a hostile value that a shell can give, and that leads nowhere outside of the working folder."""
    word = drawn.choice(_PLAUSIBLE) if drawn.random() < 0.3 else str(hostile(drawn))
    word = os.fsdecode(word.encode("utf-8", "replace")).replace("\x00", "")
    return word.replace("..", "")


@cache
def _options_of(command: str) -> list[argparse.Action]:
    actions = command_called(command).declare(argparse.ArgumentParser())
    return [action for action in actions if action.option_strings]
