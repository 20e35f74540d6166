"""Evidence against equal means that may be looked at after every world."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles

BETS = (np.arange(64) + 0.5) / 64
"""Shares of the wealth that are bet on each side; the evidence is the mean over all."""


def e_process(differences: Doubles) -> Doubles:
    """Return the evidence after each world, (..., n), that the mean of paired differences is not 0.

    ``differences``: (..., n), in [-1, 1], in the order of the worlds. The wealth of a bettor who starts with 1 and bets
    a fixed share of it that the next difference is above 0, or below, averaged over both sides and all shares [WSR].
    Where the mean is 0 the wealth is a fair game, however the differences are distributed: it ever reaches
    ``1 / level`` with a probability of at most ``level`` (Ville's inequality), however often it is looked at.

    References
    ----------
    .. [WSR] I. Waudby-Smith, A. Ramdas, Estimating Means of Bounded Random Variables by Betting, Journal of the Royal
       Statistical Society B 86(1), 2024.
    """
    wealth = np.zeros(differences.shape)
    for bet in BETS:
        for side in (bet, -bet):
            wealth += np.exp(np.minimum(np.cumsum(np.log1p(side * differences), axis=-1), _MAX_LOG))
    return wealth / (2 * BETS.size)


def anytime_p(differences: Doubles) -> float:
    """Return a p-value that holds whenever it is looked at, from paired differences in [-1, 1]; 1 without any.

    One over the most evidence so far: where the mean is 0, it is ever below ``level`` with a probability of at most
    ``level``.
    """
    return 1 / max(1.0, float(e_process(differences).max(initial=0.0)))


_MAX_LOG = 600.0
"""Keeps the wealth finite; it is decided long before."""
