"""Parameters that declare the outputs that they change leave the others as they are, byte for byte."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk

from graphnav import Latest, Stamp, Twist
from graphnav.core.stage import params_of, ports_of

SMALL: dict[str, Any] = {"size": (16, 12), "truth": True}
WITH: dict[str, dict[str, Any]] = {
    "camera_shake_s": {"camera_shake_deg": 1.0},
    "light_period_s": {"light_swing_ratio": 0.3},
    "exposure_step_s": {"exposure_step_ratio": 0.5},
    "exposure_step_ratio": {"exposure_step_s": 0.1},
    "auto_exposure_gray": {"auto_exposure_s": 0.5},
    "auto_exposure_gain_ratio": {"auto_exposure_s": 0.5},
}
"""Other parameters without which one does nothing."""
OTHER: dict[str, Any] = {
    "size": (24, 16),
    "neutral": True,
    "truth": False,
    "odometry_delay_frames": 2,
    "tilt_deg": 40.0,
    "fov_deg": 90.0,
    "odometry_hz": 20.0,
    "exposure_step_s": 0.1,
    "distortion": (-0.1, 0.01),
    "defocus_px": 1.0,
    "auto_exposure_s": 0.5,
    "auto_exposure_gain_ratio": (1.5, 2.0),
    "jpeg_quality": 20,
}


def plain(value: Any) -> Any:
    """Return messages, and what holds some, as data that can be compared."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    if hasattr(value, "__dict__"):
        return {name: plain(of) for name, of in vars(value).items() if name != "footprint_m"}
    return value


def outputs_of(kind: type[Pymunk | Robot], maps: Path, **params: Any) -> dict[str, list[Any]]:
    """Return every output of a short drive in a curve, by port."""
    world = kind(map=maps / "crossing.yaml", **SMALL | params)
    world.reset(3)
    steps, period_us = (6, 100_000) if kind is Pymunk else (60, 10_000)
    made = [world.step(Latest(Twist(0.3, 0.4), 0.0), Stamp(k * period_us)) for k in range(steps)]
    return {port: [plain(getattr(one, port)) for one in made] for port in made[0]._fields}


@pytest.mark.parametrize("kind", [Pymunk, Robot])
def test_only_the_declared_outputs_change(kind: type[Pymunk | Robot], maps: Path) -> None:
    ports = {port.name for port in ports_of(kind).outputs}
    declared = {name: param for name, param in params_of(kind).items() if param.changes}
    assert {"tilt_deg", "noise_sigma_gray", "odometry_noise_ratio", "goal_distance_ratio"} <= declared.keys()
    for name, param in declared.items():
        assert ports.intersection(param.changes), name
        needed = WITH.get(name, {})
        value = OTHER[name] if name in OTHER else param.default / 2 or 0.05
        before, after = outputs_of(kind, maps, **needed), outputs_of(kind, maps, **needed, **{name: value})
        changed = {port for port in ports if before[port] != after[port]}
        assert changed, name
        assert changed <= set(param.changes), name
