"""Measure the time of a step of the detectors and scores, under this version of graphnav or under an older one.

``python tools/bench_stages.py record FOLDER`` records what the stages get in a drive of `corridor_ccw`.
``python tools/bench_stages.py time FOLDER`` prints the median processor time of a step of each stage, ms, as JSON.
``python tools/bench_stages.py measure OLD_PYTHON [ROUNDS]`` lets both interpreters take turns on the same inputs, and
prints each stage's share of the older version's time. Only what version 0.1.0 has too is used, apart from stages that it
does not have, which are left out.
"""

from __future__ import annotations

import importlib
import inspect
import json
import math
import pickle
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import fields
from pathlib import Path
from typing import Any

import cv2
import numpy as np

import graphnav
from graphnav import Latest, Stage
from graphnav.bus import Bus
from graphnav.catalog import Catalog
from graphnav.codec import decode
from graphnav.graph import load_graph
from graphnav.runner import Runner

GRAPH, SEED, TICKS = "corridor_ccw", 3, 120
WARM_UP = 10
STEER = {"about": "zero", "strength": "gradient", "gain": 16.0}
STAGES = (
    *("planar.motion", "planar.subspace", "planar.gain", "plane.ica", "plane.affine", "plane.residual"),
    *("plane.homography", "steer.pca", "control.guard"),
    *("score.flow", "score.plane", "score.steering", "score.navigation"),
)
Tick = tuple[int, dict[str, Any]]


class Inputs:
    """A sink that keeps the decoded messages of every tick by port: their class and fields, which outlast versions."""

    def __init__(self, classes: dict[str, type]) -> None:
        self._classes = classes
        self.ticks: dict[int, dict[str, Any]] = defaultdict(dict)

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Keep one message; of several of a port the first."""
        message_class = self._classes.get(channel)
        if message_class is not None:
            message = decode(message_class, data)[2]
            kept = (message_class.__name__, dict(message.__dict__))
            self.ticks[utime].setdefault(channel.partition(".")[2], kept)


def record(folder: Path) -> None:
    """Drive, and save the inputs of the ticks that have a flow."""
    graph = load_graph(GRAPH, Catalog())
    inputs = Inputs({channel.name: channel.message for channel in graph.channels.values()})
    runner = Runner(graph, graph.make_stages(), Bus("memq://"), [inputs])
    runner.reset(SEED)
    for _ in range(TICKS + WARM_UP):
        runner.tick()
    runner.close()
    first_map = next(tick["map"] for tick in inputs.ticks.values() if "map" in tick)
    ticks = [(utime, tick | {"map": first_map}) for utime, tick in sorted(inputs.ticks.items()) if "flow" in tick]
    (folder / "ticks.pickle").write_bytes(pickle.dumps(ticks))


def stages() -> dict[str, Stage]:
    """Return the stages by name, with the parameters of the graph, those that this version of graphnav has."""
    model = next(stage.model for name, stage in load_graph(GRAPH, Catalog()).make_stages().items() if name == "planar")  # type: ignore[attr-defined]
    made = {}
    for name in STAGES:
        family, _, module = name.partition(".")
        try:
            classes = vars(importlib.import_module(f"graphnav_{family}.{module}"))
        except ModuleNotFoundError:
            continue
        stage_class = next(
            value for key, value in classes.items() if key.lower() == module.replace("_", "") and key[0].isupper()
        )
        parameters = {"model": model} if family == "planar" else STEER if family == "steer" else {}
        made[name] = stage_class(**parameters)
    return made


def message(kind: str, values: dict[str, Any]) -> Any:
    """Return a message of this version; arrays are read-only, as received ones are."""
    message_class = getattr(graphnav, kind)
    for value in values.values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return message_class(**{field.name: values[field.name] for field in fields(message_class)})


def arguments(stage: Stage, utime: int, tick: dict[str, Any]) -> dict[str, Any]:
    """Return what a step of the stage takes, by the annotations of its ``step``."""
    found: dict[str, Any] = {}
    for name, parameter in inspect.signature(stage.step).parameters.items():  # type: ignore[attr-defined]
        annotation = str(parameter.annotation)
        value = message(*tick[name]) if name in tick else None
        if "Stamp" in annotation:
            value = utime
        elif "Age" in annotation:
            value = 0.0
        elif "Latest" in annotation:
            value = Latest(value, 0.0 if value is not None else math.inf)
        elif name == "command":
            value = message(*tick["twist"])
        found[name] = value
    return found


def step_ms(folder: Path) -> dict[str, float]:
    """Return the median processor time of a step of each stage, on the recorded inputs."""
    cv2.setNumThreads(1)
    medians = {}
    for name, stage in stages().items():
        ticks: list[Tick] = pickle.loads((folder / "ticks.pickle").read_bytes())
        stage.reset(SEED)
        spent = []
        for given in [arguments(stage, utime, tick) for utime, tick in ticks]:
            begin = time.thread_time()
            stage.step(**given)  # type: ignore[attr-defined]
            spent.append(time.thread_time() - begin)
        medians[name] = 1e3 * statistics.median(spent[WARM_UP:])
    return medians


def measure(old_python: Path, rounds: int = 5) -> dict[str, float]:
    """Return each stage's time as a share of the older version's: the median over rounds in which both take turns."""
    shares: dict[str, list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        record(Path(folder))
        for _ in range(rounds):
            old, new = (_timed(python, folder) for python in (old_python, Path(sys.executable)))
            for name in old.keys() & new.keys():
                shares[name].append(new[name] / old[name])
    return {name: statistics.median(shares[name]) for name in STAGES if name in shares}


def _timed(python: Path, folder: str) -> dict[str, float]:
    done = subprocess.run([python, __file__, "time", folder], stdout=subprocess.PIPE, check=True)
    times: dict[str, float] = json.loads(done.stdout)
    return times


if __name__ == "__main__":
    mode, where, *rest = sys.argv[1:]
    if mode == "record":
        record(Path(where))
    else:
        print(json.dumps(step_ms(Path(where)) if mode == "time" else measure(Path(where), *map(int, rest)), indent=1))
