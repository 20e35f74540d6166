"""The world with a lidar: its scans, and that all else is as without."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.lidar import Lidar, LidarOutputs
from graphnav_world.world import Pymunk

from graphnav import Finished, Latest, ParamError, Scan, Stamp, Twist
from graphnav.core.codec import encode
from graphnav.core.stage import tell_readers

ROOM = """
walls:
  - {along: [[-1.05, -2.05], [3.05, -2.05], [3.05, 2.05], [-1.05, 2.05]], closed: true, thickness_m: 0.1, height_m: 0.5}
start: {at_m: [0, 0], heading_deg: HEADING}
"""


@pytest.fixture
def room(tmp_path: Path) -> Any:
    """Return what writes the map of a room of 4 m x 4 m; the robot starts 1 m from its back."""

    def write(heading_deg: float = 0.0) -> Path:
        path = tmp_path / "room.yaml"
        path.write_text(ROOM.replace("HEADING", str(heading_deg)))
        return path

    return write


def drive(world: Lidar, ticks: int, seed: int = 3, twist: Twist | None = None) -> list[LidarOutputs]:
    world.reset(seed)
    found = []
    for k in range(ticks):
        try:
            found.append(world.step(Latest(twist, 0.1), Stamp(100_000 * k)))
        except Finished as end:
            return [*found, end.outputs]
    return found


def scan_of(path: Path, **params: Any) -> Scan:
    return drive(Lidar(map=path, size=(16, 12), truth=False, **params), 1)[0].scan


def test_ranges_are_those_to_the_walls(room: Any) -> None:
    scan = scan_of(room(), lidar_noise_m=0.0, lidar_fov_deg=180.0, lidar_beams=5)
    assert scan.angles_rad() == pytest.approx(np.radians([-90, -45, 0, 45, 90]))
    assert scan.ranges_m == pytest.approx([2.0, 2.0 * math.sqrt(2), 3.0, 2.0 * math.sqrt(2), 2.0])


def test_beams_turn_with_the_robot(room: Any) -> None:
    scan = scan_of(room(90.0), lidar_noise_m=0.0, lidar_fov_deg=180.0, lidar_beams=3)
    assert scan.ranges_m == pytest.approx([3.0, 2.0, 1.0])


def test_all_around_no_beam_is_there_twice(room: Any) -> None:
    scan = scan_of(room(), lidar_fov_deg=360.0, lidar_beams=8)
    assert np.degrees(scan.angles_rad()) == pytest.approx(np.arange(-180, 180, 45))


def test_beyond_its_reach_there_is_no_echo(room: Any) -> None:
    scan = scan_of(room(), lidar_noise_m=0.0, lidar_fov_deg=180.0, lidar_beams=3, lidar_max_m=2.5)
    assert scan.ranges_m.tolist() == [2.0, math.inf, 2.0]
    near = scan_of(room(), lidar_noise_m=0.0, lidar_fov_deg=180.0, lidar_beams=3, lidar_min_m=2.5)
    assert near.ranges_m.tolist() == [2.5, 3.0, 2.5]


def test_walls_lower_than_the_beams_are_not_seen(room: Any) -> None:
    assert np.isposinf(scan_of(room(), lidar_height_m=0.6).ranges_m).all()


def test_noise_is_normal_independent_and_seeded(room: Any) -> None:
    world, exact = Lidar(map=room(), lidar_noise_m=0.02), scan_of(room(), lidar_noise_m=0.0).ranges_m
    errors = np.array([one.scan.ranges_m - exact for one in drive(world, 20)])
    # 14,400 readings tell the deviation to 0.6 %, correlations to 0.01.
    assert errors.std() == pytest.approx(0.02, rel=0.03)
    assert abs(errors.mean()) < 1e-3
    assert abs(np.corrcoef(errors[1:].ravel(), errors[:-1].ravel())[0, 1]) < 0.04
    assert abs(np.corrcoef(errors[:, 1:].ravel(), errors[:, :-1].ravel())[0, 1]) < 0.04
    again, other = drive(world, 1)[0].scan, drive(world, 1, seed=4)[0].scan
    assert np.array_equal(again.ranges_m - exact, errors[0])
    assert not np.array_equal(other.ranges_m, again.ranges_m)


def test_all_else_is_as_without_a_lidar(maps: Path) -> None:
    params: dict[str, Any] = {"map": maps / "crossing.yaml", "size": (32, 24), "slip_ratio": 0.1}
    with_lidar = drive(Lidar(**params), 4, twist=Twist(v_mps=0.3, omega_radps=0.2))
    world = Pymunk(**params)
    world.reset(3)
    for k, found in enumerate(with_lidar):
        other = world.step(Latest(Twist(v_mps=0.3, omega_radps=0.2), 0.1), Stamp(100_000 * k))
        for name, message in other._asdict().items():
            mine = getattr(found, name)
            assert (mine is None) == (message is None)
            assert message is None or encode(mine, 0, 0) == encode(message, 0, 0), name


def test_the_camera_is_rendered_where_it_is_read(room: Any) -> None:
    for read, has_image in ((("scan",), False), (("scan", "image"), True), (("scan", "truth"), True)):
        world = Lidar(map=room(), size=(16, 12))
        tell_readers(world, read)
        assert (drive(world, 2)[-1].image is not None) == has_image


def test_a_lidar_that_measures_nothing_is_an_error(room: Any) -> None:
    with pytest.raises(ParamError, match="'lidar_min_m' is 4, not below 'lidar_max_m' 4"):
        Lidar(map=room(), lidar_min_m=4.0, lidar_max_m=4.0).check()
