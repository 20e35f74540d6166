"""Loss: `record` and `spy` lose no more than raw python-lcm that listens at the same time, and say what they lose."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from bench_record import LOADS, RAW, SPIES, Loss, measure

from acceptance.drives import say
from acceptance.spy_terminal import HAS_TMUX

ROUNDS = 4
DURATION_S = 10.0
NOISE_RATIO = 0.001
"""Each program has its own socket, which the kernel may catch at another moment: so much more than raw is not more."""


def loss_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Print what each listener lost of each load in each round, and what it says; judge the sums over the rounds."""
    if not HAS_TMUX:
        say("     tmux is missing: the full-screen spy is left out")
    heard: dict[tuple[str, str, str], list[tuple[Loss, Loss]]] = {}
    for number in range(ROUNDS):
        for channels in LOADS:
            with tempfile.TemporaryDirectory() as folder:
                losses = measure(channels, DURATION_S, Path(folder), SPIES[number % len(SPIES)])
            raw = {loss.channel: loss for loss in losses if loss.listener == RAW}
            for loss in losses:
                say(f"     {loss}")
                if loss.listener != RAW:
                    kind = loss.load, loss.channel, loss.listener
                    heard.setdefault(kind, []).append((loss, raw[loss.channel]))
    checks = [_is_no_worse(*kind, pairs) for kind, pairs in heard.items()]
    return all(checks)


def _is_no_worse(load: str, channel: str, name: str, pairs: Sequence[tuple[Loss, Loss]]) -> bool:
    """Say whether a listener lost no more than raw python-lcm in the same rounds, and told all of it."""
    own_ratio, raw_ratio = (_lost_ratio(losses) for losses in zip(*pairs, strict=True))
    is_told = all(own.is_told for own, _ in pairs)
    good = is_told and own_ratio <= raw_ratio + NOISE_RATIO
    told = "all of it told" if is_told else "NOT all of it told"
    mark = "ok  " if good else "MISS"
    say(f"{mark} {load}, {channel}: {name} lost {own_ratio:.3%}, {told}; raw python-lcm lost {raw_ratio:.3%}")
    return good


def _lost_ratio(losses: Sequence[Loss]) -> float:
    return 1 - sum(loss.has for loss in losses) / sum(loss.sent for loss in losses)
