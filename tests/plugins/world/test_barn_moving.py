"""Worlds of cylinders that move on polynomials: sixty, the same ones at all times, within their bounds."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.geometry.polynomial_path import PolynomialPath
from graphnav_world.geometry.scene import Kind
from graphnav_world.maps.barn_moving import FIELD_M, GRADES, MIN_BEND_M, RADIUS_M, grade_of, paths, within
from graphnav_world.maps.corridor_keys import N_MOVING_WORLDS
from graphnav_world.maps.world_map import WorldMap, load_map
from graphnav_world.world import Pymunk
from numpy.polynomial import chebyshev

from graphnav import Finished, Latest, Stamp, State, Twist
from graphnav.arrays import Doubles
from graphnav.core.stage import tell_run_seed

ROBOT_M = 0.27
WORLDS = range(N_MOVING_WORLDS)
TIMES_S = np.arange(0.0, 100.0, 0.25)


def courses(world: WorldMap) -> list[PolynomialPath]:
    return [body.course for body in world.draw.bodies if isinstance(body.course, PolynomialPath)]


def where(path: PolynomialPath, times_s: Doubles = TIMES_S) -> Doubles:
    return np.array([path.at(float(time_s)) for time_s in times_s])


def loaded(maps: Path, number: int, seed: int = 0) -> WorldMap:
    return load_map(maps / "barn_moving.yaml", seed, ROBOT_M, number)


def test_sixty_worlds_differ_and_are_drawn_alike_each_time() -> None:
    firsts = {path.at(0.0) for number in WORLDS for path in paths(0, number)}
    assert len(firsts) == sum(len(paths(0, number)) for number in WORLDS), "no cylinder is in two worlds"
    for number in (0, 31, 59):
        for one, other in zip(paths(0, number), paths(0, number), strict=True):
            assert (where(one) == where(other)).all()


def test_the_run_s_seed_is_the_number_of_the_world_and_draws_other_surfaces(maps: Path) -> None:
    world, again, other = loaded(maps, 49), loaded(maps, 109, seed=7), loaded(maps, 50)
    assert [one.at(3.0) for one in courses(world)] == [one.at(3.0) for one in courses(again)]
    assert [one.at(3.0) for one in courses(world)] != [one.at(3.0) for one in courses(other)]
    assert world.draw.textures["floor"].mean != again.draw.textures["floor"].mean
    stage = Pymunk(map=maps / "barn_moving.yaml", size=(16, 12))
    tell_run_seed(stage, 109)
    stage.reset(seed=5)
    drawn = stage.step(Latest[Twist](), Stamp(0)).state
    assert drawn is not None
    assert drawn.moving[:, :2].tolist() == [list(one.at(0.0)) for one in courses(world)]


def test_another_collection_has_other_worlds(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    found = []
    for collection in (0, 1):
        path.write_text(f"barn_moving: {{world: 49, collection: {collection}}}\n")
        found.append([one.at(0.0) for one in courses(load_map(path, 0, ROBOT_M))])
    assert found[0] == [one.at(0.0) for one in paths(0, 49)]
    assert set(found[0]).isdisjoint(found[1])


@pytest.mark.parametrize("number", WORLDS)
def test_cylinders_keep_to_the_numbers_of_their_grade_to_the_field_and_off_the_start(number: int) -> None:
    grade, found = grade_of(number), paths(0, number)
    assert grade == GRADES[number // 20]
    assert grade.count[0] <= len(found) <= grade.count[1]
    for path in found:
        assert grade.order[0] <= path.order <= grade.order[1]
        assert grade.mean_mps[0] <= path.mean_mps <= grade.mean_mps[1]
        assert path.speed_mps <= grade.max_mps
        assert path.swing_mps < path.mean_mps
        assert path.sharpest_m >= MIN_BEND_M
        places = where(path)
        step_m = np.linalg.norm(np.diff(places, axis=0), axis=1)
        assert step_m.max() <= path.speed_mps * 0.25
        assert (path.through_m >= FIELD_M[0] + RADIUS_M - 1e-9).all()
        assert (path.through_m <= FIELD_M[1] - RADIUS_M + 1e-9).all()
        assert (places >= FIELD_M[0] + RADIUS_M - 1e-6).all()
        assert (places <= FIELD_M[1] - RADIUS_M + 1e-6).all()
        assert np.hypot(*(places - (-2.25, 3.0)).T).min() > RADIUS_M + ROBOT_M + 0.9
        from_side_to_side_m = np.abs(path.through_m[-1] - path.through_m[0])
        assert np.isclose(from_side_to_side_m, FIELD_M[1] - FIELD_M[0] - 2 * RADIUS_M).any()


def test_worlds_grow_harder_and_have_every_order() -> None:
    worlds = [paths(0, number) for number in WORLDS]
    for value in (len, lambda found: np.mean([path.mean_mps for path in found])):
        easy, medium, hard = (np.mean([value(worlds[number]) for number in range(k, k + 20)]) for k in (0, 20, 40))
        assert easy < medium < hard
    assert {path.order for found in worlds for path in found} == {1, 2, 3, 4, 5, 6}


def test_a_series_is_scaled_only_as_far_as_it_leaves_its_bounds() -> None:
    at = np.linspace(-1, 1, 2001)
    for seed in range(50):
        series = np.random.default_rng(seed).normal(size=1 + seed % 6 + 1)
        values, bounded = chebyshev.chebval(at, series), chebyshev.chebval(at, within(series, -1.0, 1.5))
        assert bounded.min() >= -1.0 - 1e-9
        assert bounded.max() <= 1.5 + 1e-9
        if values.min() >= -1.0 and values.max() <= 1.5:
            np.testing.assert_array_equal(bounded, values)
        else:
            slope = np.ptp(bounded) / np.ptp(values)
            np.testing.assert_allclose(bounded - bounded[0], slope * (values - values[0]), atol=1e-9)
            assert slope == pytest.approx(min(1.0, 2.5 / np.ptp(values)), abs=1e-5)


def test_the_map_has_walls_around_and_the_start_and_goal_of_barn(maps: Path) -> None:
    world, barn = loaded(maps, 3), load_map(maps / "barn.yaml", 0, ROBOT_M, 3)
    assert world.draw.start == barn.draw.start
    assert (world.draw.goal_m == barn.draw.goal_m).all()
    assert {body.kind for body in world.draw.bodies} == {Kind.WALL, Kind.MOVING}
    assert {body.height_m for body in world.draw.bodies} == {1.0}
    inner = [body.sides.reshape(-1, 2) for body in world.draw.bodies if body.kind == Kind.WALL]
    assert np.abs(np.concatenate(inner)[:, 0] + 2.25).min() == pytest.approx(2.25), "as wide as the field"


def drive(maps: Path, number: int, twist: Twist, until_s: float) -> list[State]:
    """Return the states of a drive by one command, up to a contact or the goal."""
    world = Pymunk(map=maps / "barn_moving.yaml", size=(16, 12), robot_radius_m=ROBOT_M, max_speed_mps=2.0)
    tell_run_seed(world, number)
    world.reset(seed=1)
    found: list[Any] = []
    for k in range(round(until_s * 20)):
        try:
            found.append(world.step(Latest(twist, 0.0), Stamp(k * 50_000)).state)
        except Finished as end:
            found.append(end.outputs.state)
            break
    return found


def test_a_robot_that_stays_at_the_start_is_never_touched(maps: Path) -> None:
    states = drive(maps, 59, Twist(v_mps=0.0, omega_radps=0.0), 20.0)
    assert len(states) == 400
    assert not any(state.contact for state in states)
    velocity = np.diff([state.moving[:, :2] for state in states], axis=0) / 0.05
    limits = np.array([path.speed_mps for path in paths(0, 59)])
    assert (np.linalg.norm(velocity, axis=2) <= limits + 1e-9).all()
    assert np.linalg.norm(velocity, axis=2).mean() > 0.4


def test_straight_on_through_a_hard_world_something_is_touched(maps: Path) -> None:
    states = drive(maps, 59, Twist(v_mps=1.0, omega_radps=0.0), 12.0)
    assert states[-1].contact
    gap_m = np.hypot(*(states[-1].moving[:, :2] - (states[-1].x_m, states[-1].y_m)).T).min() - RADIUS_M - ROBOT_M
    assert abs(gap_m) < 0.1
    assert math.isclose(states[-1].x_m, -2.25, abs_tol=1e-9)
