"""Watchers on a network that loses packets change nothing in a lockstep run over processes, and say what is lost."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from bench_record import RAW, SPIES, listened
from testbed.drives import GRAPHNAV
from testbed.lossy import lossy, url_of

from graphnav import Recording
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

GRAPH, UNTIL_S = "corridor_ccw", 20
SENT, HEARD = ("239.255.82.5", 7995), ("239.255.82.6", 7996)
SPIED_S = 120.0
MIN_MESSAGES = 50
"""Channels with fewer of them, such as that of the map, are left out."""
MAX_ENDS = 20
"""So many messages at the ends of a channel may be lost without a gap that tells it; more in a row are not likely."""


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the log of the run in one process, without watchers."""
    folder = tmp_path_factory.mktemp("alone")
    _run(folder / "run", "--no-tap")
    return (folder / "run" / RunFolder.LOG).read_bytes()


@pytest.mark.parametrize("ratio", [0.01, 0.05, 0.2])
def test_watchers_of_a_lossy_network(targets: Targets, alone: bytes, tmp_path: Path, ratio: float) -> None:
    """Equality of the log, and of each watcher what it has and says it lost, summed over the channels."""
    run = tmp_path / "run"

    def drive() -> dict[str, int]:
        _run(run, "--processes", "--pace", "1")
        with Recording(run / RunFolder.LOG) as log:
            counts = {name: log.count(name) for name in log.channels}
        return {name: count for name, count in counts.items() if count >= MIN_MESSAGES}

    with lossy(SENT, HEARD, ratio, seed=1) as packets:
        losses = listened(f"{ratio:.0%}", (url_of(HEARD), HEARD[1]), drive, tmp_path, SPIES[-1], SPIED_S)
    is_equal = (run / RunFolder.LOG).read_bytes() == alone
    targets.check(
        f"{packets['lost']} of {packets['came']} packets lost ({packets['lost'] / packets['came']:.1%}); the log of "
        f"the run over processes is {'equal' if is_equal else 'NOT equal'} to that of one process without watchers",
        good=is_equal and packets["lost"] > 0,
    )
    for listener in dict.fromkeys(loss.listener for loss in losses):
        own = [loss for loss in losses if loss.listener == listener]
        sent, has = sum(loss.sent for loss in own), sum(loss.has for loss in own)
        text = f"{listener}: {sent - has} of {sent} messages on {len(own)} channels are missing"
        if listener == RAW:
            targets.check(text, good=has < sent)
            continue
        untold = [loss.sent - loss.has - (loss.says_lost or 0) for loss in own]
        text += f"; it says {sum(loss.says_lost or 0 for loss in own)}, and cannot know of {sum(untold)} at the ends"
        targets.check(text, good=all(0 <= n <= MAX_ENDS for n in untold) and sum(map(bool, untold)) < len(own))


def _run(folder: Path, *options: str) -> None:
    words = ["run", GRAPH, "--until", str(UNTIL_S), "--no-pictures", "--set", "run.record=all", "-o", str(folder)]
    around = os.environ | {"LCM_DEFAULT_URL": url_of(SENT)}
    subprocess.run([str(GRAPHNAV), *words, *options], check=True, capture_output=True, env=around)
