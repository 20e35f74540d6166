"""Loss: `record` and `spy` lose no more than raw python-lcm that listens at the same time, and say what they lose."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from bench_record import LOADS, RAW, SPIES, Loss, measure
from testbed.terminal import HAS_TMUX

from tests.targets import Targets

ROUNDS = 4
DURATION_S = 10.0
NOISE_RATIO = 0.001
"""Each program has its own socket, which the kernel may catch at another moment: so much more than raw is not more."""


def test_loss(targets: Targets, tmp_path: Path) -> None:
    """Losses of each listener, of each load and round, and what it says; judged are the sums over the rounds."""
    if not HAS_TMUX:
        targets.say("tmux is missing: the full-screen spy is left out")
    heard: dict[tuple[str, str, str], list[tuple[Loss, Loss]]] = {}
    for number in range(ROUNDS):
        for place, channels in enumerate(LOADS):
            folder = tmp_path / f"{number}-{place}"
            folder.mkdir()
            losses = measure(channels, DURATION_S, folder, SPIES[number % len(SPIES)])
            raw = {loss.channel: loss for loss in losses if loss.listener == RAW}
            for loss in losses:
                targets.say(str(loss))
                if loss.listener != RAW:
                    kind = loss.load, loss.channel, loss.listener
                    heard.setdefault(kind, []).append((loss, raw[loss.channel]))
            shutil.rmtree(folder)
    for (load, channel, name), pairs in heard.items():
        own_ratio, raw_ratio = (_lost_ratio(losses) for losses in zip(*pairs, strict=True))
        is_told = all(own.is_told for own, _ in pairs)
        told = "all of it told" if is_told else "NOT all of it told"
        text = f"{load}, {channel}: {name} lost {own_ratio:.3%}, {told}; raw python-lcm lost {raw_ratio:.3%}"
        targets.check(text, good=is_told and own_ratio <= raw_ratio + NOISE_RATIO)


def _lost_ratio(losses: Sequence[Loss]) -> float:
    return 1 - sum(loss.has for loss in losses) / sum(loss.sent for loss in losses)
