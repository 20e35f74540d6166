"""Teach a network to drive as the planner on the true map does, from the robot's own pictures, and write it as ONNX.

``python tools/train_policy.py drives -o graphs/graphnav_graphs/models/policy_160x120.onnx`` makes the drives of all
rounds in the folder ``drives`` and goes on where it stopped. It needs torch, which no extra of graphnav brings:
pip install torch==2.13.0 onnx onnxruntime

Imitation by DAgger: in the first round the planner drives, and chance by turns; in the others the network of the round
before, and the planner says at every frame what it would do. The seeds are below 900, the worlds of BARN those for
tuning that are neither 1 nor 5 modulo 12.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from policy_training.drives import WORLDS, Drive, made, seed_of

from graphnav.core.errors import UserError, printable

INSTALL = "pip install torch==2.13.0 onnx onnxruntime"
HALF = ("tight", "crowd", "crossers", "laps")
"""Worlds of which a round has half as many drives: they are learned soon, or teach little."""


@dataclass(frozen=True)
class Round:
    """Drives of a round and how the network learns from them and from all before; ``first``: numbers of the drives."""

    policy_ratio: float
    chance_ratio: float
    first: int
    drives: int
    first_barn: int
    barn: int
    epochs: float
    rate: float
    afresh: bool
    """Whether the network starts afresh, not where the round before ended."""


ROUNDS = (
    Round(0.0, 0.3, 0, 10, 0, 40, 6, 3e-3, afresh=True),
    Round(0.7, 0.1, 10, 12, 40, 50, 1.5, 2e-3, afresh=False),
    Round(0.5, 0.15, 22, 12, 90, 50, 1, 2e-3, afresh=False),
    Round(0.8, 0.1, 34, 12, 140, 60, 9, 3e-3, afresh=True),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Drive, teach and write the network; return 2 for what cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="for the drives; what it has already is not made again")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the network's file")
    parser.add_argument("-j", "--jobs", type=int, default=2, help="drives at once (default: %(default)s)")
    parser.add_argument("--drives", type=int, help="of each world at most, for a trial")
    parser.add_argument("--until", type=float, default=60.0, help="seconds of a drive at most (default: %(default)s)")
    arguments = parser.parse_args(argv)
    try:
        train(arguments.folder, arguments.output, arguments.jobs, arguments.drives, arguments.until)
    except UserError as error:
        print(printable(str(error)), file=sys.stderr)
        return 2
    return 0


def train(folder: Path, output: Path, jobs: int, max_drives: int | None, until_s: float) -> None:
    """Make all rounds; print how each went and how long it took."""
    if find_spec("torch") is None:
        raise UserError.of("tools/train_policy.py needs torch", INSTALL)
    from policy_training.network import taught_and_written  # noqa: PLC0415  # it imports torch

    network = None
    for number, one in enumerate(ROUNDS):
        begin_s = time.monotonic()
        here = folder / f"round_{number}"
        ended = Counter(outcome for _, outcome in made(drives_of(one, network, max_drives, until_s), here, jobs))
        drove_s = time.monotonic() - begin_s
        print(f"round {number}: {dict(ended)}, {drove_s:.0f} s", flush=True)
        before = None if one.afresh else folder / f"round_{number - 1}.pt"
        files = [file for past in range(number + 1) for file in sorted((folder / f"round_{past}").glob("*.npz"))]
        network = folder / f"round_{number}.onnx"
        taught_and_written(files, before, network, epochs=one.epochs, rate=one.rate)
        print(f"{network}: {network.stat().st_size} bytes, {time.monotonic() - begin_s - drove_s:.0f} s", flush=True)
    assert network is not None
    output.write_bytes(network.read_bytes())


def drives_of(one: Round, policy: Path | None, max_drives: int | None, until_s: float) -> list[Drive]:
    """Return the drives of a round."""
    planned = []
    for world in WORLDS:
        first, count = (one.first_barn, one.barn) if world == "barn" else (one.first, one.drives)
        count = count // 2 if world in HALF else count
        for number in range(first, first + min(count, count if max_drives is None else max_drives)):
            seed = seed_of(world, number)
            planned.append(Drive(world, seed, policy, one.policy_ratio, one.chance_ratio, until_s))
    return planned


if __name__ == "__main__":
    sys.exit(main())
