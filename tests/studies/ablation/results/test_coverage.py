"""How often intervals and tests reject a true null: in short, and as a slow test over as many studies as docs cite."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from graphnav.arrays import Doubles
from graphnav.studies.ablation.results import ALPHA, difference_interval, p_value, student
from tests.targets import Targets

STUDIES, SHORT = 20_000, 2000
"""Simulated studies of a cell."""
WORLDS = (6, 10, 20, 50)
SEED = 11
"""Of all simulated studies; cells draw from generators of their own."""
SCATTER = 3 * (0.05 * 0.95 / SHORT) ** 0.5
"""Three standard errors of a share of 5 % of the studies."""
Draw = Callable[[np.random.Generator, tuple[int, int]], Doubles]
"""Draws values of one variant: (studies, worlds)."""


@dataclass(frozen=True)
class Null:
    """Two variants that are alike, and in which share of studies they may be called different."""

    name: str
    draw: Draw
    is_binary: bool
    min_rejected: float
    max_rejected: float


def _share(p: float) -> Draw:
    return lambda rng, shape: (rng.random(shape) < p).astype(float)


def _normal(rng: np.random.Generator, shape: tuple[int, int]) -> Doubles:
    return rng.normal(size=shape)


def _exponential(rng: np.random.Generator, shape: tuple[int, int]) -> Doubles:
    return rng.exponential(size=shape)


def _lognormal(rng: np.random.Generator, shape: tuple[int, int]) -> Doubles:
    return rng.lognormal(size=shape)


def _beta(rng: np.random.Generator, shape: tuple[int, int]) -> Doubles:
    return rng.beta(8.0, 1.0, shape)


NULLS = (
    Null("normal", _normal, is_binary=False, min_rejected=0.045, max_rejected=0.055),
    Null("exponential", _exponential, is_binary=False, min_rejected=0.0, max_rejected=0.055),
    Null("lognormal", _lognormal, is_binary=False, min_rejected=0.0, max_rejected=0.055),
    Null("beta(8, 1)", _beta, is_binary=False, min_rejected=0.0, max_rejected=0.055),
    *(
        Null(f"0/1, p = {p:g}", _share(p), is_binary=True, min_rejected=0.0, max_rejected=0.06)
        for p in (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 0.98)
    ),
)
MEANS: dict[str, tuple[Draw, float]] = {
    "normal": (_normal, 0.0),
    "beta(8, 1)": (_beta, 8 / 9),
    "exponential": (_exponential, 1.0),
    "lognormal": (_lognormal, float(np.exp(0.5))),
}
"""Distributions of a single metric, with their means."""


@pytest.mark.parametrize("n_worlds", [6, 20])
@pytest.mark.parametrize("null", NULLS, ids=lambda null: null.name)
def test_true_nulls_are_rejected_as_rarely_as_promised(null: Null, n_worlds: int) -> None:
    by_interval, by_test = rejected(null, n_worlds, SHORT, (7, n_worlds))
    assert null.min_rejected - SCATTER <= by_interval <= null.max_rejected + SCATTER
    assert by_test <= 0.05 + SCATTER


def test_intervals_of_single_skewed_means_are_short() -> None:
    draw, mean = MEANS["lognormal"]
    assert covered(draw, mean, 6, SHORT, (7, 6)) < 0.9, "so they are marked approximate"
    draw, mean = MEANS["normal"]
    assert covered(draw, mean, 6, SHORT, (7, 6)) == pytest.approx(0.95, abs=SCATTER)


@pytest.mark.slow
def test_coverage(targets: Targets) -> None:
    """Intervals and tests reject no more true nulls than they promise."""
    targets.say(f"rejected of {STUDIES} studies without a difference, by the interval and by the test, at n = {WORLDS}")
    for place, null in enumerate(NULLS):
        found = [rejected(null, n, STUDIES, (SEED, place, n)) for n in WORLDS]
        cells = "   ".join(f"{100 * interval:4.1f} {100 * test:4.1f}" for interval, test in found)
        targets.check(f"{null.name:14} {cells} %", good=all(is_accepted(null, *both) for both in found))
    targets.say("means of a single metric that are covered by their t interval")
    for place, (name, (draw, mean)) in enumerate(MEANS.items()):
        shares = [covered(draw, mean, n, STUDIES, (SEED, 100 + place, n)) for n in WORLDS]
        targets.say(f"{name:14} {'   '.join(f'{100 * share:4.1f}' for share in shares)} %")


def rejected(null: Null, n_worlds: int, n_studies: int, seed: tuple[int, ...]) -> tuple[float, float]:
    """Return the share of studies in which the interval leaves out 0, and in which the test rejects."""
    rng = np.random.default_rng(seed)
    shape = (n_studies, n_worlds)
    pairs = list(zip(null.draw(rng, shape), null.draw(rng, shape), strict=True))
    intervals = [difference_interval(this, base, is_binary=null.is_binary) for this, base in pairs]
    p_values = [p_value(this, base, is_binary=null.is_binary) for this, base in pairs]
    by_interval = float(np.mean([low > 0 or high < 0 for low, high in intervals]))
    return by_interval, float(np.mean(np.array(p_values) <= ALPHA))


def is_accepted(null: Null, by_interval: float, by_test: float) -> bool:
    """Return whether the interval's share lies within bounds; a test may reject less, but not more."""
    return null.min_rejected <= by_interval <= null.max_rejected and by_test <= null.max_rejected


def covered(draw: Draw, mean: float, n_worlds: int, n_studies: int, seed: tuple[int, ...]) -> float:
    """Return the share of studies whose interval of the mean holds it."""
    values = draw(np.random.default_rng(seed), (n_studies, n_worlds))
    return float(np.mean([low <= mean <= high for low, high in map(student, values)]))
