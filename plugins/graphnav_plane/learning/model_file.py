"""Learned models: a network, and its file of named arrays in numpy's npz, without pickled objects.

Arrays: ``mean``, ``scale`` (features,), ``weights_0``, ``biases_0``, ... of the layers, all float32, and ``about``, a
string of JSON: ``format`` (1), ``features`` (their names), ``rows``, ``cols``, ``step_px`` (the grid), and where the
model comes from: graph, settings, maps, seeds, samples, versions.
"""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from graphnav import ParamError, read_regular
from graphnav.arrays import Floats
from graphnav_plane.learning.features import NAMES

Arrays = Mapping[str, npt.NDArray[Any]]
FORMAT = 1
MAX_BYTES = 64 * 1024**2
"""Of a model's file."""
TEACH = "teach one: python tools/teach_learned.py -o FILE"
_DAMAGED = (ValueError, KeyError, TypeError, AttributeError, EOFError, RuntimeError, SyntaxError, struct.error)
"""Exceptions of numpy, zipfile and json for files that they cannot read."""
_MAX_DEVIATION = 8.0
"""Features further from their mean, in standard deviations, count as this far: what was never taught stays finite."""


@dataclass(frozen=True)
class LearnedModel:
    """A network, the grid on which it was taught, and where it comes from."""

    network: Network
    shape: tuple[int, int]
    step_px: int
    about: Mapping[str, Any]


def write_model(path: Path, model: LearnedModel) -> None:
    """Write a model; the same model gives the same bytes."""
    (rows, cols), network = model.shape, model.network
    about = {"format": FORMAT, "features": NAMES, "rows": rows, "cols": cols, "step_px": model.step_px, **model.about}
    layers = {f"weights_{k}": weights for k, weights in enumerate(network.weights)}
    layers |= {f"biases_{k}": biases for k, biases in enumerate(network.biases)}
    described = np.array(json.dumps(about, indent=1))
    with path.open("wb") as file:
        np.savez(file, mean=network.mean, scale=network.scale, **layers, about=described)  # type: ignore[arg-type]


def read_model(path: Path) -> LearnedModel:
    """Return the model in the file at ``path``.

    Raises
    ------
    ParamError
        The file does not exist, is damaged, or holds no such model; names the parameter 'model'.
    """
    try:
        with np.load(io.BytesIO(read_regular(path, MAX_BYTES)), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        about = json.loads(str(arrays["about"]))
        shape, step_px = (int(about["rows"]), int(about["cols"])), int(about["step_px"])
        known = about["format"], tuple(about["features"])
    except OSError as error:
        raise ParamError("model", f"cannot read {path}: {error.strerror or error}", TEACH) from error
    except (*_DAMAGED, zipfile.BadZipFile) as error:
        raise ParamError("model", f"{path} is not a learned model", TEACH) from error
    if known != (FORMAT, NAMES):
        raise ParamError("model", f"{path} was taught by another version of graphnav, with other features", TEACH)
    return LearnedModel(_network(path, arrays), shape, step_px, about)


def _network(path: Path, arrays: Arrays) -> Network:
    """Return the network of these arrays, checked: types, sizes from layer to layer, finite."""
    layers = sum(name.startswith("weights_") for name in arrays)
    names = ["mean", "scale", *(f"{kind}_{k}" for kind in ("weights", "biases") for k in range(layers))]
    if missing := [name for name in names if name not in arrays]:
        raise ParamError("model", f"{path} lacks {', '.join(missing)}", TEACH)
    found = [arrays[name] for name in names]
    if not all(array.dtype == np.float32 and np.isfinite(array).all() for array in found):
        raise ParamError("model", f"{path} holds values that are not finite float32 numbers", TEACH)
    network = Network(found[0], found[1], tuple(found[2 : 2 + layers]), tuple(found[2 + layers :]))
    sizes = (len(NAMES), *(biases.size for biases in network.biases))
    wanted: list[tuple[int, ...]] = [sizes[:1], sizes[:1], *pairwise(sizes), *((size,) for size in sizes[1:])]
    if not layers or sizes[-1] != 1 or [array.shape for array in found] != wanted or not (network.scale > 0).all():
        raise ParamError("model", f"the arrays of {path} do not fit together", TEACH)
    return network


@dataclass(frozen=True)
class Network:
    """A multilayer perceptron: standardised features, layers of rectified sums, the log-odds of obstacle.

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
