"""Measure the time of a step of the detectors and scores against an older version of graphnav.

``record FOLDER`` saves what the stages get in a drive of `corridor_ccw`. ``time FOLDER`` prints the median processor
time of a step of each, ms, as JSON. ``measure OLD_PYTHON [ROUNDS]`` lets this and an older version's interpreter take
turns on the same inputs, and prints each stage's share of the older time. Uses only what version 0.1.0 has too.
"""

from __future__ import annotations

import importlib
import inspect
import json
import math
import pickle
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

import graphnav
from graphnav import Latest, Stage
from graphnav.core.catalog import Catalog
from graphnav.core.codec import decode
from graphnav.core.graph import load_graph

if TYPE_CHECKING:
    from taking_turns import Ratio

GRAPH, SEED, TICKS, WARM_UP = "corridor_ccw", 3, 120, 10
STEER = {"about": "zero", "strength": "gradient", "gain": 16.0}
STAGES = (
    *("planar.motion", "planar.subspace", "planar.gain", "plane.ica", "plane.affine", "plane.residual"),
    *("plane.homography", "steer.pca", "control.guard"),
    *("score.flow", "score.plane", "score.steering", "score.navigation"),
)


class Inputs:
    """A sink that keeps the decoded messages of every tick by port: the names of their classes, and their fields."""

    def __init__(self, classes: dict[str, type]) -> None:
        self._classes = classes
        self.ticks: dict[int, dict[str, Any]] = defaultdict(dict)

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Keep one message; of several of a port the first."""
        if channel in self._classes:
            decoded: Any = decode(self._classes[channel], data)[2]
            kept = (type(decoded).__name__, dict(decoded.__dict__))
            self.ticks[utime].setdefault(channel.partition(".")[2], kept)


def record(folder: Path) -> None:
    """Drive, and save the inputs of the ticks that have a flow."""
    from graphnav.core.runner import Lockstep  # noqa: PLC0415 - the older version, which only times, has no such name

    graph = load_graph(GRAPH, Catalog())
    inputs = Inputs({channel.name: channel.message for channel in graph.channels.values()})
    lockstep = Lockstep(graph, graph.make_stages(), [inputs])
    lockstep.reset(SEED)
    for _ in range(TICKS + WARM_UP):
        lockstep.tick()
    lockstep.engine.close()
    first_map = next(tick["map"] for tick in inputs.ticks.values() if "map" in tick)
    ticks = [(utime, tick | {"map": first_map}) for utime, tick in sorted(inputs.ticks.items()) if "flow" in tick]
    (folder / "ticks.pickle").write_bytes(pickle.dumps(ticks))


def stages() -> dict[str, Stage]:
    """Return the stages that this version has by name, with the graph's parameters."""
    planar: Any = load_graph(GRAPH, Catalog()).make_stages()["planar"]
    made = {}
    for name in STAGES:
        family, _, module = name.partition(".")
        try:
            classes = vars(importlib.import_module(f"graphnav_{family}.{module}"))
        except ModuleNotFoundError:
            continue
        parameters = {"model": planar.model} if family == "planar" else STEER if family == "steer" else {}
        made[name] = classes[module.capitalize()](**parameters)
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
    """Return the mean processor time of a step of each stage, its summary included, on the recorded inputs.

    The mean, because a stage may defer work to a later step or to its summary.
    """
    cv2.setNumThreads(1)
    means = {}
    for name, stage in stages().items():
        ticks = pickle.loads((folder / "ticks.pickle").read_bytes())  # noqa: S301  # its own
        stage.reset(SEED)
        spent = []
        for utime, tick in ticks:
            given = arguments(stage, utime, tick)
            begin = time.thread_time()
            stage.step(**given)  # type: ignore[attr-defined]
            spent.append(time.thread_time() - begin)
        begin = time.thread_time()
        stage.summary()
        spent.append(time.thread_time() - begin)
        means[name] = 1e3 * sum(spent[WARM_UP:]) / len(ticks[WARM_UP:])
    return means


def measure(old_python: Path, rounds: int = 5) -> dict[str, Ratio]:
    """Return each stage's share of the older version's time; both versions take turns."""
    from taking_turns import Ratio, results_in_turn  # noqa: PLC0415 - the older version needs none

    def times_of(python: Path | str) -> Callable[[], dict[str, float]]:
        return lambda: json.loads(subprocess.check_output([str(python), __file__, "time", folder]))

    with tempfile.TemporaryDirectory() as folder:
        record(Path(folder))
        found = results_in_turn({"old": times_of(old_python), "new": times_of(sys.executable)}, rounds)
    return {
        name: Ratio.of([new[name] / old[name] for old, new in zip(found["old"], found["new"], strict=True)])
        for name in STAGES
        if name in found["old"][0] and name in found["new"][0]
    }


if __name__ == "__main__":
    mode, where, *rest = sys.argv[1:]
    if mode == "record":
        record(Path(where))
    elif mode == "time":
        print(json.dumps(step_ms(Path(where)), indent=1))
    else:
        from taking_turns import load_told

        with load_told():
            for name, share in measure(Path(where), *map(int, rest)).items():
                print(f"{name:18} {share}")
