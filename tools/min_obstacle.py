"""How thin and how low an obstacle the map shows, and from how far: a table of width and height.

``python tools/min_obstacle.py [--seeds 0 1 2] [--set plane.cell_px=2 ...]`` drives a robot straight past posts of every
width and height, with the camera, flow, detector and map of the graph ``navigate``. Printed is the distance ahead of
the robot's middle at which the map shows a post first, the median over seeds, in metres; ``-`` where it shows it in at
most half of the drives. The last line is the share of places without a post, opposite of each, where it shows one.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

import graphnav
from graphnav import Latest, LocalMap, Map, Role, Stage, State, hookimpl, param

FAMILY = "posts"
WIDTHS_M = (0.01, 0.02, 0.03, 0.05, 0.10)
HEIGHTS_M = (0.03, 0.05, 0.10, 0.30, 1.00)
SPACING_M = 0.8
"""Between two posts along the way: the map marks some 0.15 m of floor behind each."""
_ASIDE_M = 0.32
_BEYOND_M = 0.06
"""How far from a post's rim an obstacle on the map may be and still be that post."""
_MAX_AHEAD_M = 1.5
_SPEED_MPS = 0.3


class Shown(Stage):
    """How far ahead of the robot the map shows each standing obstacle first, and the place opposite of it."""

    role: ClassVar[Role] = "score"

    path: Path = param(doc="where the distances go, JSON")

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget what was shown."""
        self._ahead_m: dict[str, dict[int, float]] = {"posts": {}, "opposite": {}}

    def step(self, map: LocalMap, state: State, world: Latest[Map]) -> None:  # noqa: A002  # the port's name
        """Note which obstacles the map shows in this frame for the first time."""
        if world.value is None:
            return
        c, s = np.cos(state.yaw_rad), np.sin(state.yaw_rad)
        for body in range(len(world.value.kind)):
            rim_m = world.value.vertices_m[world.value.body == body]
            x_m, y_m = rim_m.mean(axis=0)
            for name, side in (("posts", 1.0), ("opposite", -1.0)):
                away_m = np.array([x_m - state.x_m, side * y_m - state.y_m])
                forward_m, left_m = c * away_m[0] + s * away_m[1], c * away_m[1] - s * away_m[0]
                if not 0.0 < forward_m < _MAX_AHEAD_M or body in self._ahead_m[name]:
                    continue
                near_m = float(map.obstacle_m_at(np.array([forward_m]), np.array([left_m]))[0])
                if near_m < np.ptp(rim_m[:, 0]) / 2 + _BEYOND_M:
                    self._ahead_m[name][body] = float(forward_m)

    def summary(self) -> Mapping[str, float]:
        """Write what was found; there are no metrics."""
        self.path.write_text(json.dumps(self._ahead_m), encoding="utf-8")
        return {}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stage."""
    return [Shown]


def world(sizes: list[tuple[float, float]]) -> dict[str, Any]:
    """Return a map with a post of each width and height, in this order, to alternate sides of the x axis."""
    posts = [
        {
            "circle": {"center_m": [1.5 + SPACING_M * k, (-1) ** k * (_ASIDE_M + width / 2)], "radius_m": width / 2},
            "height_m": height,
        }
        for k, (width, height) in enumerate(sizes)
    ]
    textures = {
        "floor": {"mean": [105, 145], "contrast": [28, 40], "grain_m": [0.1, 0.2]},
        "obstacle": {"mean": [60, 190], "contrast": [20, 32], "grain_m": [0.03, 0.12]},
    }
    return {"obstacles": posts, "start": {"at_m": [0, 0]}, "textures": textures}


def graph(map_path: Path, found: Path, until_s: float) -> dict[str, Any]:
    """Return a graph that drives straight on and looks as `navigate` does."""
    return {
        "extends": "navigate",
        "run": {"until_s": until_s},
        "stages": {
            "robot": {"with": {"map": str(map_path)}},
            "steer": {"use": "steer.forward", "in": {"plane": "plane.plane"}},
            "control": {"with": {"max_speed_mps": _SPEED_MPS}, "in": {"map": None}},
            "guard": {"with": {"max_obstacle_ratio": 1, "unjudged": "ignore"}},
            "drive": None,
            "sense": None,
            "sight": None,
            "shown": {
                "use": f"{FAMILY}.shown",
                "with": {"path": str(found)},
                "in": {"map": "local.local_map", "state": "robot.state", "world": "robot.map"},
            },
        },
    }


def measured(seed: int, overrides: Mapping[str, Any], folder: Path) -> tuple[dict[tuple[float, float], float], float]:
    """Return the distances at which posts by width and height were shown, and the share shown opposite of them."""
    sizes = [(width, height) for width in WIDTHS_M for height in HEIGHTS_M]
    np.random.default_rng(seed).shuffle(sizes)
    found = folder / f"{seed}.json"
    (folder / "posts.yaml").write_text(json.dumps(world(sizes)), encoding="utf-8")
    until_s = (1.5 + SPACING_M * len(sizes)) / _SPEED_MPS
    path = folder / "graph.yaml"
    path.write_text(json.dumps(graph(folder / "posts.yaml", found, until_s)), encoding="utf-8")
    graphnav.run(
        path,
        seed=seed,
        set=dict(overrides),
        plugins=[Path(__file__)],
        folder=folder / f"run_{seed}",
        record="small",
        pictures=False,
    )
    shown = json.loads(found.read_text(encoding="utf-8"))
    by_size = {sizes[int(body)]: float(ahead_m) for body, ahead_m in shown["posts"].items()}
    return by_size, len(shown["opposite"]) / len(sizes)


def override(item: str) -> tuple[str, Any]:
    """Return key and value of ``KEY=VALUE``; what is not JSON is a string."""
    key, _, value = item.partition("=")
    try:
        return key, json.loads(value)
    except json.JSONDecodeError:
        return key, value


def main() -> int:
    """Drive and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as of 'graphnav run'")
    args = parser.parse_args()
    overrides = dict(override(item) for item in args.set)
    with tempfile.TemporaryDirectory() as folder:
        drives = [measured(seed, overrides, Path(folder)) for seed in args.seeds]
    print("width   " + "".join(f"{f'{100 * height:.0f} cm':>9}" for height in HEIGHTS_M) + "   high")
    for width in WIDTHS_M:
        cells = []
        for height in HEIGHTS_M:
            ahead_m = [by_size[width, height] for by_size, _ in drives if (width, height) in by_size]
            enough = 2 * len(ahead_m) > len(drives)
            cells.append(f"{statistics.median(ahead_m):.2f}" if enough else "-")
        print(f"{100 * width:>4.0f} cm " + "".join(f"{cell:>9}" for cell in cells))
    print(f"shown where there is none: {statistics.mean(share for _, share in drives):.1%}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
