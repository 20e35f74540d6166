"""Do with graphnav what a script does, as a command: functions of the package on spoiled files and hostile arguments.

An error of graphnav is printed, as a command would print it; any other exception is let out.
"""

from __future__ import annotations

import itertools
import random
import sys
from collections.abc import Callable, Mapping
from typing import Any

import graphnav
from attacks.spoil import hostile

DOOR = "python-door"
_OK, _REFUSED = 0, 2
_MAX_MESSAGES = 20
_ARGUMENTS = ("set", "seed", "until_s", "plugins", "pace", "tap", "live", "url", "folder")


def check_graph(path: str, _seed: str) -> None:
    """Check a graph."""
    for problem in graphnav.check(path):
        print(ascii(problem.what))


def load_graph(path: str, _seed: str) -> None:
    """Load a graph and show it."""
    graph = graphnav.load(path)
    print(graphnav.draw(graph))


def run_graph(path: str, _seed: str) -> None:
    """Run a graph for a moment and read what it leaves."""
    run = graphnav.run(path, until_s=0.2, pictures=False)
    print(run.outcome, ascii(run.failure), repr(run))
    read_log(str(run.folder), "")


def run_with(path: str, seed: str) -> None:
    """Run a good graph with a hostile argument."""
    drawn = random.Random(f"arguments {seed}")
    name = drawn.choice(_ARGUMENTS)
    value = hostile(drawn)
    if name == "set":
        value = {drawn.choice(("flow.window_px", "run.until_s", "robot", "", "a.b.c", "x\x1b[2J")): value}
    arguments: dict[str, Any] = {"until_s": 0.1, "pictures": False} | {name: value}
    if name == "live":
        arguments["url"] = "udpm://239.255.92.1:20092?ttl=0"
    graphnav.run(path, **arguments)


def read_log(path: str, _seed: str) -> None:
    """Read all that a log offers."""
    with graphnav.open_log(path) as log:
        print(ascii(log.damage), log.duration_s, repr(log), len(log._repr_html_()), len(log.graph))
        for channel in log.channels:
            for sample in itertools.islice(log.messages(channel), _MAX_MESSAGES):
                repr(sample)
            times_s = log.times_s(channel)
            if len(times_s):
                log.at(channel, float(times_s[0]))
            log.stack(channel, "v_mps")


DOORS: Mapping[str, Callable[[str, str], None]] = {
    "check": check_graph,
    "load": load_graph,
    "run": run_graph,
    "arguments": run_with,
    "log": read_log,
}


def main(words: list[str]) -> int:
    """Go through a door: its name, a path, and a seed for what is drawn."""
    name, path, seed = words
    try:
        DOORS[name](path, seed)
    except graphnav.GraphnavError as error:
        print(error)
        return _REFUSED
    return _OK


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
