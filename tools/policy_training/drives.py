"""Drives that teach: the planner on the true map says at every frame what it would do, also where another one drives.

A drive becomes one file of arrays: its pictures at half of their size, the beacon, and the planner's direction.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import yaml  # noqa: TID251  # a graph that this writes

import graphnav
from graphnav import Goal, Image, Recording, Steering, block_mean

MIXING = Path(__file__).with_name("mixing.py")
SHRINK = 2
"""Pixels of the camera to a side of one that is kept."""
COMFORT_M = 0.35
"""Clearance that the planner prefers; `steer.oracle` has 0.25 by default, which forgives a pupil less."""
CORRIDORS = ("corners", "tight", "crowd", "laps")
PILLARS = ("shake", "odometry", "speed", "doors", "low", "crossers", "tilt", "light", "neutral")
WORLDS = (*CORRIDORS, *PILLARS, "barn")
N_BARN = 300
FRAMES = 15
"""Pictures that the network is given, the newest last."""
SEEDS_EACH = 69


@dataclass(frozen=True)
class Speeds:
    """How fast a world is driven: those of `navigate` there, with less in BARN."""

    max_speed_mps: float = 0.3
    max_turn_radps: float = 1.2


SPEEDS = {"speed": Speeds(1.0, 2.0), "barn": Speeds(1.0, 2.0)}


@dataclass(frozen=True)
class Drive:
    """A drive that teaches: where, by which seed, and who drives; ``policy``: the network, None before the first."""

    world: str
    seed: int
    policy: Path | None
    policy_ratio: float
    chance_ratio: float
    until_s: float = 45.0


def tuning_barn_worlds() -> list[int]:
    """Return the worlds of BARN to learn from: for tuning, without those that judge (1 and 5 modulo 12)."""
    return [number for number in range(N_BARN) if number % 3 and number % 12 not in (1, 5)]


def seed_of(world: str, number: int) -> int:
    """Return the seed of a world's drive, below 900: each of the suite's worlds has 69 of its own.

    Worlds of one seed may share their layout. In BARN the seed is the world, and with each 150 drives the surfaces.
    """
    if world == "barn":
        worlds = tuning_barn_worlds()
        return worlds[number * 7 % len(worlds)] + N_BARN * (number // len(worlds) % 3)
    return WORLDS.index(world) * SEEDS_EACH + number % SEEDS_EACH


def graph_of(drive: Drive) -> dict[str, Any]:
    """Return the graph of a drive, as YAML has it: the world, the planner, the policy and who drives."""
    speeds = SPEEDS.get(drive.world, Speeds())
    limits = {"max_speed_mps": speeds.max_speed_mps, "max_turn_radps": speeds.max_turn_radps}
    absent = ["flow", "planar", "plane", "sense", "sight", "guard"]
    absent += ["heading"] if drive.world in CORRIDORS else []
    stages: dict[str, Any] = dict.fromkeys(absent)
    stages |= {
        "robot": {"in": {"command": "mix.twist"}},
        "steer": {
            "use": "steer.oracle",
            "with": {"comfort_m": COMFORT_M},
            "in": {"state": "robot.state", "map": "robot.map"},
        },
        "mix": {
            "use": "mixing.mix",
            "with": {"policy_ratio": drive.policy_ratio, "chance_ratio": drive.chance_ratio, **limits},
            "in": {"teacher": "control.twist", "state": "robot.state"},
        },
    }
    if drive.world == "barn":
        stages["robot"]["with"] = {
            "map": "maps/barn.yaml",
            "robot_radius_m": 0.27,
            "max_speed_mps": 2.0,
            "speed_up_s": 0.5,
        }
        stages["drive"] = {"use": "score.barn"}
    if drive.policy is not None:
        stages["policy"] = policy_stage(drive.policy, drive.world)
        stages["mix"]["in"]["policy"] = "policy.twist"
    base = "speed" if drive.world == "barn" else drive.world
    return {"extends": f"suite/{base}", "run": {"until_s": drive.until_s}, "stages": stages}


def policy_stage(policy: Path, world: str) -> dict[str, Any]:
    """Return the stage that drives by a network, as `parts/learned` has it."""
    speeds, has_beacon = SPEEDS.get(world, Speeds()), world not in CORRIDORS
    inputs: dict[str, str | float] = {
        "image": "image.pixels",
        "bearing_rad": "goal.bearing_rad" if has_beacon else 0,
        "distance_m": "goal.distance_m" if has_beacon else 0,
        "max_speed_mps": speeds.max_speed_mps,
        "max_turn_radps": speeds.max_turn_radps,
    }
    return {
        "use": "policy.onnx",
        "with": {
            "file": str(policy.resolve()),
            "inputs": inputs,
            "history": {"image": FRAMES},
            "outputs": {"v_mps": "twist.v_mps", "omega_radps": "twist.omega_radps"},
        },
        "in": {"image": "robot.image"} | ({"goal": "robot.goal"} if has_beacon else {}),
    }


def made(drives: Sequence[Drive], folder: Path, jobs: int) -> Iterator[tuple[Drive, str]]:
    """Make the drives that a folder lacks, some at a time; yield each with its outcome, in order."""
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        yield from zip(drives, pool.map(make, drives, [folder] * len(drives)), strict=True)


def file_of(drive: Drive, folder: Path) -> Path:
    """Return the file of a drive."""
    return folder / f"{drive.world}_{drive.seed:03d}.npz"


def make(drive: Drive, folder: Path) -> str:
    """Make a drive that a folder lacks; return its outcome."""
    path = file_of(drive, folder)
    if path.exists():
        return "there already"
    with tempfile.TemporaryDirectory() as scratch:
        graph = Path(scratch) / "drive.yaml"
        graph.write_text(yaml.safe_dump(graph_of(drive)))
        log_folder = Path(scratch) / "run"
        run = graphnav.run(
            graph, seed=drive.seed, folder=log_folder, plugins=[MIXING], record="all", pictures=False, check=True
        )
        with Recording(log_folder / "run.lcmlog") as log:
            arrays = _arrays(log, drive.world)
        with graphnav.written_aside(path) as aside:
            np.savez_compressed(aside, **arrays)
        return run.outcome


def _arrays(log: Recording, world: str) -> dict[str, Any]:
    """Return what a drive teaches: pictures (n, h, w), bearing and distance (n, 2; 0, 0 without), directions (n,)."""
    n = min(log.count("robot.image"), log.count("steer.steering"))
    pictures, goals, directions = [], np.zeros((n, 2), np.float32), np.zeros(n, np.float32)
    for number in range(n):
        image = log.message("robot.image", number)[2]
        steering = log.message("steer.steering", number)[2]
        assert isinstance(image, Image)
        assert isinstance(steering, Steering)
        pictures.append(np.rint(block_mean(image.pixels.astype(np.float32), SHRINK)).astype(np.uint8))
        directions[number] = math.remainder(steering.theta_rad, 2 * math.pi)
        if world not in CORRIDORS:
            goal = log.message("robot.goal", number)[2]
            assert isinstance(goal, Goal)
            goals[number] = goal.bearing_rad, goal.distance_m
    speeds = SPEEDS.get(world, Speeds())
    limits = np.array([speeds.max_speed_mps, speeds.max_turn_radps], np.float32)
    return {"pictures": np.array(pictures), "goals": goals, "directions": directions, "limits": limits}
