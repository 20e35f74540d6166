"""Teach plane.learned: drive over the tuning worlds, collect features with their truth, fit a small network.

``python tools/teach_learned.py -o graphs/graphnav_graphs/models/learned_160x120.npz`` taught the shipped model. Another
camera, speed or flow: add ``--set TARGET=VALUE`` as with ``graphnav run``, for instance
``--set robot.tilt_deg=50 --set planar.model=models/tilt_50.lcmlog``. The same arguments give the same file on one
machine. Every fifth drive only judges the network, whose AUROC on them is printed and written into the file.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sklearn
from graphnav_plane.detector import MIN_VECTORS
from graphnav_plane.learning.features import Features
from graphnav_plane.learning.model_file import LearnedModel, Network, write_model
from sklearn.metrics import roc_auc_score
from sklearn.neural_network import MLPClassifier
from threadpoolctl import threadpool_limits

import graphnav
from graphnav import Flow, Planar, Recording, Truth, block_mean
from graphnav.arrays import Bools, Floats
from graphnav.core.errors import Problem, UserError, printable
from graphnav.core.graph import Override

GRAPH = Path(__file__).with_suffix(".yaml")
FIRST_SEED = 100
DRIVES = {"corridor_ccw": 8, "corridor_cw": 8, "pillars": 12, "crowded": 6, "crossing": 4}
"""Drives by map. On each of them, the odometry errs by one of `ODOMETRY_ERRORS`."""
WANDERING = {"empty": 5, "corridor_ccw": 4, "pillars": 4}
"""Drives that turn at random, until they touch something."""
ODOMETRY_ERRORS = (0.02, 0.0, 0.1, 0.25)
EVERY_FRAMES = 4
JUDGING = 5
LAYERS = (24, 12)
EPOCHS = 20


@dataclass(frozen=True)
class Drive:
    """A drive: its seed and what it changes of the graph."""

    seed: int
    changes: Mapping[str, object]


@dataclass(frozen=True)
class Samples:
    """Features of cells (n, features), which of them are obstacle (n,), and the grid that they come from."""

    features: Floats
    obstacle: Bools
    shape: tuple[int, int]
    step_px: int


def main(argv: Sequence[str] | None = None) -> int:
    """Teach and write the model; return 2 for arguments that cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, help="the model's file")
    parser.add_argument("--set", action="append", default=[], help="change the graph of all drives, as graphnav run")
    parser.add_argument("--drives", type=int, help="the first drives only, for a trial")
    arguments = parser.parse_args(argv)
    try:
        planned, given = _planned(arguments.drives), _given(arguments.set)
        _check_output(arguments.output)
        teach(planned, given, arguments.output)
    except UserError as error:
        print(printable(str(error)), file=sys.stderr)
        return 2
    return 0


def teach(planned: Sequence[Drive], given: Mapping[str, object], output: Path) -> None:
    """Make the drives, fit the network and write it."""
    taught: list[Samples] = []
    judging: list[Samples] = []
    for number, drive in enumerate(planned):
        samples = collected(drive, given)
        (judging if number % JUDGING == JUDGING - 1 else taught).append(samples)
        print(f"{drive.seed} {drive.changes}: {len(samples.obstacle)} cells, {samples.obstacle.mean():.1%} obstacle")
    with threadpool_limits(1):
        network = fitted(taught)
    auroc = {"taught": auroc_of(network, taught), "judging": auroc_of(network, judging)}
    about = {
        "graph": GRAPH.name,
        "set": given,
        "drives": [{"seed": drive.seed, "set": drive.changes} for drive in planned],
        "samples": sum(samples.obstacle.size for samples in taught),
        "auroc": {name: round(value, 4) for name, value in auroc.items()},
        "versions": {"graphnav": graphnav.__version__, "sklearn": sklearn.__version__, "numpy": np.__version__},
    }
    write_model(output, LearnedModel(network, taught[0].shape, taught[0].step_px, about))
    print(f"{output}: {output.stat().st_size} bytes, AUROC {auroc}")


def _planned(number: int | None) -> Sequence[Drive]:
    """Return the first drives, all without a number."""
    if number is not None and number < 1:
        raise UserError.of(f"--drives {number} leaves no drive to teach from", "write --drives 1 or more")
    return list(drives())[:number]


def _given(texts: Sequence[str]) -> dict[str, object]:
    """Return what ``--set`` says, value by target."""
    problems: list[Problem] = []
    overrides = Override.parse_all(texts, problems)
    if problems:
        raise UserError(problems)
    return {str(override.target): override.value for override in overrides}


def _check_output(output: Path) -> None:
    """Make the model's folder; raise UserError where the file cannot be written, before any drive is made."""
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        is_writable = os.access(output.parent, os.W_OK) and not output.is_dir()
    except OSError:
        is_writable = False
    if not is_writable:
        raise UserError.of(f"cannot write {output}", "choose another file with -o")


def drives() -> Iterator[Drive]:
    """Return all drives, in a fixed order, each with a seed of its own."""
    planned: list[dict[str, object]] = [
        {"robot.map": f"maps/{name}.yaml"} for name, count in DRIVES.items() for _ in range(count)
    ]
    planned += [
        {"robot.map": f"maps/{name}.yaml", "control": "control.wander"}
        for name, count in WANDERING.items()
        for _ in range(count)
    ]
    for number, changes in enumerate(planned):
        error = ODOMETRY_ERRORS[number % len(ODOMETRY_ERRORS)]
        yield Drive(FIRST_SEED + number, {**changes, "robot.odometry_scale_ratio": error})


def collected(drive: Drive, given: Mapping[str, object]) -> Samples:
    """Return the cells of every fourth frame of a drive."""
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        graphnav.run(
            GRAPH, set={**drive.changes, **given}, seed=drive.seed, folder=run, record="all", pictures=False, check=True
        )
        with Recording(run / "run.lcmlog") as log:
            return _cells(log)


def _cells(log: Recording) -> Samples:
    looking = Features()
    features, obstacle = [], []
    numbers = {
        channel: {utime: number for number, utime in enumerate(log.utimes(channel))}
        for channel in ("flow.flow", "robot.truth")
    }
    for number in range(log.count("planar.planar")):
        utime, _, planar = log.message("planar.planar", number)
        flow, truth = (log.message(channel, at[utime])[2] for channel, at in numbers.items())
        assert isinstance(planar, Planar)
        assert isinstance(flow, Flow)
        assert isinstance(truth, Truth)
        found, valid, step_px = looking.of(flow, planar, MIN_VECTORS)
        if number % EVERY_FRAMES:
            continue
        factor = step_px // truth.step_px
        below_horizon = block_mean(np.isfinite(truth.depth_m).astype(np.float32), factor)[valid] > 0
        is_obstacle = block_mean(truth.obstacle.astype(np.float32), factor)[valid] > 1 / 2
        features.append(found[below_horizon])
        obstacle.append(is_obstacle[below_horizon])
    rows, cols = valid.shape
    return Samples(np.concatenate(features), np.concatenate(obstacle), (rows, cols), step_px)


def fitted(taught: Sequence[Samples]) -> Network:
    """Return the network that fits best, by scikit-learn's Adam from a fixed start."""
    features = np.concatenate([samples.features for samples in taught])
    mean, scale = features.mean(axis=0), features.std(axis=0) + np.float32(1e-6)
    plain = Network(mean, scale, (), ())
    classifier = MLPClassifier(LAYERS, batch_size=512, max_iter=EPOCHS, n_iter_no_change=EPOCHS, random_state=0)
    classifier.fit(plain.standardised(features), np.concatenate([samples.obstacle for samples in taught]))
    weights, biases = (
        tuple(layer.astype(np.float32) for layer in layers) for layers in (classifier.coefs_, classifier.intercepts_)
    )
    return Network(mean, scale, weights, biases)


def auroc_of(network: Network, judging: Sequence[Samples]) -> float:
    """Return the area under the receiver operating characteristic over all of these cells; NaN without any."""
    if not judging:
        return float("nan")
    score = np.concatenate([network.log_odds(samples.features) for samples in judging])
    return float(roc_auc_score(np.concatenate([samples.obstacle for samples in judging]), score))


if __name__ == "__main__":
    sys.exit(main())
