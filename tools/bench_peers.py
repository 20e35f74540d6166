"""Measure the hop and the throughput of pictures between two processes, of graphnav and of libraries like it.

The hop is one way, from the publication of a numpy array to a numpy array in the other process, at 50 Hz; the
throughput is of a sender that never waits by itself. Beside both stands what was lost: a fast message that does not
arrive is not fast. Each library is used as its own documentation advises for large messages on one machine; its program
is in `tools/peers`, all by one protocol: the same clock, pacing, payload and warm-up. They take turns, each time in new
processes. The libraries are installed from their registry into a virtual environment of their own, in build/peers; what
cannot be installed is left out, with the reason.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from itertools import count
from pathlib import Path

from peers.protocol import Job
from taking_turns import load_told, results_in_turn

TOOLS = Path(__file__).resolve().parent
ENVIRONMENT = TOOLS.parent / "build" / "peers"
SIZES = {19_200: (120, 160), 76_800: (240, 320), 307_200: (480, 640), 921_600: (720, 1280)}
"""Rows and columns by the number of bytes."""
RATE_HZ, N_WARM_UP, N_PACED, FLOOD_S = 50.0, 20, 100, 0.7
MAX_S = 120.0
"""The time of one job, starts included."""
OURS, RIVALS = "graphnav edge", ("dora", "ezmsg", "zenoh")
"""The hop of the first is to be shorter than that of each rival, and loses nothing."""


@dataclass(frozen=True)
class Peer:
    """A library: its program and that one's roles, what installs it, and how its array comes to be.

    ``buffers``: which can be chosen.
    """

    program: str
    roles: tuple[str, ...]
    array: str
    packages: tuple[str, ...] = ()
    buffers: tuple[str, ...] = ("stock", "large")


PEERS: Mapping[str, Peer] = {
    "graphnav edge": Peer("graphnav_peer", ("edge",), "view of the message", buffers=("stock",)),
    "graphnav channel": Peer("graphnav_peer", ("channel",), "view of the message"),
    "python-lcm": Peer("lcm_peer", ("hear", "send"), "view of the message", ("lcm",)),
    "pyzmq": Peer("zmq_peer", ("hear", "send"), "view of the message", ("pyzmq",)),
    "zenoh": Peer("zenoh_peer", ("hear", "send"), "copy", ("eclipse-zenoh",)),
    "iceoryx2": Peer("iceoryx2_peer", ("hear", "send"), "view of shared memory", ("iceoryx2",)),
    "ezmsg": Peer("ezmsg_peer", ("both",), "view of shared memory", ("ezmsg",)),
    "dora": Peer("dora_peer", ("both",), "view of shared memory", ("dora-rs", "dora-rs-cli")),
}


@dataclass(frozen=True)
class Found:
    """The result of one job: hops in µs, MB/s; how many were sent and arrived, at the rate and as fast as it goes."""

    hops_us: Sequence[float]
    mb_s: float
    sent: int
    arrived: int
    flood_sent: int
    flood_arrived: int
    out_of_order: int


All = Mapping[int, dict[tuple[str, str], list[Found]]]
"""The results, by size, and by name and buffers; one of each round."""


def installed(peers: Sequence[str], environment: Path = ENVIRONMENT) -> tuple[dict[str, str], dict[str, str]]:
    """Install what the peers need; return the versions of those that are there, and why others are not."""
    python = environment / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", "numpy"], check=True, stderr=subprocess.DEVNULL)
    versions, missing = {}, {}
    ask = "import sys; from importlib.metadata import version; print(*map(version, sys.argv[1:]))"
    for name in peers:
        packages = PEERS[name].packages
        if not packages:
            versions[name] = version("graphnav")
            continue
        words = [str(python), "-m", "pip", "install", "-q", *packages]
        done = subprocess.run(words, check=False, capture_output=True, text=True)
        if done.returncode:
            errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            missing[name] = (errors or done.stderr.splitlines() or ["pip failed"])[-1]
            continue
        told = subprocess.run([str(python), "-c", ask, *packages], check=True, capture_output=True, text=True)
        versions[name] = told.stdout.split()[0]
    return versions, missing


def measured(name: str, job: Job, environment: Path = ENVIRONMENT) -> Found:
    """Let a peer do a job; raises RuntimeError with what it printed if it does not end well."""
    peer = PEERS[name]
    python = str(environment / "bin" / "python") if peer.packages else sys.executable
    with tempfile.TemporaryDirectory(prefix="peer-") as scratch:
        folder = Path(scratch)
        job.write(folder)
        with (folder / "log.txt").open("wb") as output:
            processes = [
                subprocess.Popen(
                    [python, "-m", f"peers.{peer.program}", str(folder), role],
                    stdout=output,
                    stderr=output,
                    cwd=folder,
                    env=os.environ | {"PYTHONPATH": str(TOOLS)},
                    start_new_session=True,
                )
                for role in peer.roles
            ]
            try:
                statuses = [process.wait(MAX_S) for process in processes]
            except subprocess.TimeoutExpired:
                statuses = [-1]
            finally:
                for process in processes:
                    with suppress(ProcessLookupError):
                        os.killpg(process.pid, 9)
                    process.wait()
        try:
            sent, heard = (json.loads((folder / f"{side}.json").read_text()) for side in ("sent", "heard"))
        except (OSError, ValueError):
            printed = (folder / "log.txt").read_text(errors="replace").strip()[-2000:]
            raise RuntimeError(f"{name} ended with {statuses}: {printed}") from None
    return Found(
        heard["hops_us"],
        heard.get("flood_mb_s", 0.0),
        sent["paced"],
        heard["paced"],
        sent.get("flood", 0),
        heard.get("flood", 0),
        heard["out_of_order"],
    )


def compared(peers: Sequence[str], sizes: Sequence[int], rounds: int, tell: Callable[[str], None]) -> All:
    """Let all take turns; Ctrl-C ends that with what there is."""
    found: All = {size: {(name, kind): [] for name in peers for kind in PEERS[name].buffers} for size in sizes}
    numbers, failed = count(), set[tuple[int, str, str]]()

    def turn(size: int, name: str, buffers: str) -> None:
        if (size, name, buffers) in failed:
            return
        job = Job(*SIZES[size], RATE_HZ, N_WARM_UP, N_PACED, FLOOD_S, buffers == "large", next(numbers) % 100)
        try:
            found[size][name, buffers].append(measured(name, job))
        except RuntimeError as error:
            failed.add((size, name, buffers))
            tell(f"left out at {size} bytes, {buffers} buffers: {error}")

    rivals = {f"{s} {name} {kind}": partial(turn, s, name, kind) for s, of in found.items() for name, kind in of}
    try:
        results_in_turn(rivals, rounds)
    except KeyboardInterrupt:
        tell("stopped: these are the rounds up to there")
    for size, name, kind in failed:
        found[size].pop((name, kind))
    return found


COLUMNS = (
    "bytes", "library", "buffers", "hop p50 µs", "p90 µs", "arrived at 50 Hz", "MB/s", "arrived of the flood",
    "out of order", "array",
)  # fmt: skip


def rows_of(found: All) -> list[tuple[str, ...]]:
    """Return the rows of the table: medians of the rounds with their minimum and maximum, sums of counts."""
    rows: list[tuple[str, ...]] = []
    for n_bytes, by_peer in found.items():
        for (name, buffers), turns in by_peer.items():
            heard = [one for one in turns if len(one.hops_us) > 1]
            rows.append(
                (
                    str(n_bytes),
                    name,
                    buffers,
                    _spread([statistics.median(one.hops_us) for one in heard]),
                    _spread([statistics.quantiles(one.hops_us, n=10, method="inclusive")[8] for one in heard]),
                    f"{sum(one.arrived for one in turns)} of {sum(one.sent for one in turns)}",
                    _spread([one.mb_s for one in turns]),
                    f"{sum(one.flood_arrived for one in turns)} of {sum(one.flood_sent for one in turns)}",
                    str(sum(one.out_of_order for one in turns)),
                    PEERS[name].array,
                )
            )
    return rows


def verdicts(found: All) -> list[tuple[bool, str]]:
    """Return whether each target is met, and its words: our hop to that of each rival, and what we lost."""
    told = []
    for n_bytes, by_peer in found.items():
        for (name, buffers), turns in by_peer.items():
            if name == OURS:
                lost = sum(one.sent - one.arrived for one in turns)
                told.append((lost == 0, f"{n_bytes} bytes: {name}, {buffers} buffers, lost {lost} at {RATE_HZ:g} Hz"))
            elif name in RIVALS and (OURS, "stock") in by_peer:
                ours, theirs = (
                    statistics.median([statistics.median(one.hops_us) for one in of if one.hops_us] or [float("inf")])
                    for of in (by_peer[OURS, "stock"], turns)
                )
                told.append((ours < theirs, f"{n_bytes} bytes: hop of {OURS} / {name}, {buffers}: {ours / theirs:.2f}"))
    return told


def _spread(values: Sequence[float]) -> str:
    if not values:
        return "none arrived"
    return f"{statistics.median(values):.0f} [{min(values):.0f}, {max(values):.0f}]"


def print_table(rows: Sequence[Sequence[str]], *, markdown: bool) -> None:
    """Print rows below their columns, for the terminal or as Markdown."""
    if markdown:
        print(*(f"| {' | '.join(row)} |" for row in (COLUMNS, ["---"] * len(COLUMNS), *rows)), sep="\n")
        return
    widths = [max(map(len, column)) for column in zip(COLUMNS, *rows, strict=True)]
    for row in (COLUMNS, *rows):
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def main() -> int:
    """Measure and print; return 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", nargs="+", choices=PEERS, default=list(PEERS), metavar="NAME", help=", ".join(PEERS))
    parser.add_argument("--bytes", nargs="+", type=int, choices=SIZES, default=list(SIZES), help="sizes of a picture")
    parser.add_argument("--rounds", type=int, default=5, help="how often each takes its turn (default: %(default)s)")
    parser.add_argument("--markdown", action="store_true", help="print a table for the documentation")
    parser.add_argument("--fresh", action="store_true", help="make the virtual environment again")
    args = parser.parse_args()
    if args.fresh:
        shutil.rmtree(ENVIRONMENT, ignore_errors=True)
    with load_told():
        versions, missing = installed(args.peers)
        for name, why in missing.items():
            print(f"left out: {name} cannot be installed: {why}")
        print(", ".join(f"{name} {one}" for name, one in versions.items()))
        found = compared(list(versions), args.bytes, args.rounds, lambda line: print(line, file=sys.stderr))
        print_table(rows_of(found), markdown=args.markdown)
        judged = verdicts(found)
        for is_met, words in judged:
            print(f"{'ok  ' if is_met else 'MISS'} {words}")
    return 0 if all(is_met for is_met, _ in judged) else 1


if __name__ == "__main__":
    sys.exit(main())
