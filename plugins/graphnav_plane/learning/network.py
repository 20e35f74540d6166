"""A small neural network: standardised features, layers of rectified sums, the log-odds of obstacle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Floats

_MAX_DEVIATION = 8.0
"""Features further from their mean, in standard deviations, count as this far: what was never taught stays finite."""


@dataclass(frozen=True)
class Network:
    """A multilayer perceptron with one output.

    Parameters
    ----------
    mean, scale
        (features,), by which features are standardised.
    weights, biases
        Of each layer, (inputs, outputs) and (outputs,); the last has one output.
    """

    mean: Floats
    scale: Floats
    weights: tuple[Floats, ...]
    biases: tuple[Floats, ...]

    def log_odds(self, features: Floats) -> Floats:
        """Return the log-odds of obstacle (n,) of cells with ``features`` (n, features); 0 is even."""
        values = self.standardised(features)
        for weights, biases in zip(self.weights[:-1], self.biases[:-1], strict=True):
            values = np.maximum(values @ weights + biases, np.float32(0))
        return np.asarray((values @ self.weights[-1] + self.biases[-1])[:, 0])

    def standardised(self, features: Floats) -> Floats:
        """Return ``features`` (n, features) as the first layer takes them."""
        return np.asarray(np.clip((features - self.mean) / self.scale, -_MAX_DEVIATION, _MAX_DEVIATION))
