"""Propose parameters: the tree-structured Parzen estimator of Optuna, over what was tried so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graphnav.studies.tuning.search_range import SearchRange
from graphnav.studies.tuning.trial import DEFAULT, Trial, ranks

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution

    from graphnav.core.stage import Better

RANDOM_TRIALS = 10
"""Trials of a rival that are drawn at random before the estimator has enough to go by."""


def propose(
    space: Sequence[SearchRange],
    center: Mapping[str, Any],
    tried: Sequence[Trial],
    metrics: Mapping[str, Better],
    n: int,
    seed: int,
) -> list[dict[str, Any]]:
    """Return the parameters of the next ``n`` trials of a rival.

    The proposals depend on what was tried, on the seed and on nothing else, so that a tuning that is resumed goes on
    as it would have. ``center`` has the values of the trial that changes none; where one has no place in its range, as
    null among numbers, nothing is learned from that trial.

    References
    ----------
    .. [TPE] J. Bergstra et al., Algorithms for Hyper-Parameter Optimization, NeurIPS 2011.
    .. [Optuna] T. Akiba et al., Optuna: A Next-generation Hyperparameter Optimization Framework, KDD 2019.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    spread: dict[str, BaseDistribution] = {one.target: _distribution(one) for one in space}
    sampler = optuna.samplers.TPESampler(seed=_mixed(seed, len(tried)), n_startup_trials=RANDOM_TRIALS)
    study = optuna.create_study(direction="maximize", sampler=sampler)
    for trial, rank in zip(tried, ranks(tried, metrics), strict=True):
        params = center if trial.number == DEFAULT else trial.params
        if all(one.has_place(params[one.target]) for one in space):
            shown = {one.target: one.clipped(params[one.target]) for one in space}
            study.add_trial(optuna.trial.create_trial(params=shown, distributions=spread, value=rank))
    asked = [study.ask(spread).params for _ in range(n)]
    return [{one.target: one.rounded(params[one.target]) for one in space} for params in asked]


def _distribution(searched: SearchRange) -> BaseDistribution:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if searched.kind == "choice":
        return CategoricalDistribution(searched.choices)
    if searched.kind == "integer":
        return IntDistribution(int(searched.low), int(searched.high), log=searched.is_log)
    return FloatDistribution(searched.low, searched.high, log=searched.is_log)


def _mixed(seed: int, n_tried: int) -> int:
    """Return a seed of its own for every batch."""
    return (seed * 1_000_003 + n_tried) % 2**32
