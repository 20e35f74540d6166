"""Missing parts of `world.mujoco` are told in one line before a run."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from graphnav_mujoco import engine
from graphnav_mujoco.world import Mujoco

from graphnav import ParamError, UserError, check


def test_without_mujoco_the_command_that_installs_it_is_told(maps: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "choose_gl", lambda: None)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(UserError) as told:
        Mujoco(map=maps / "empty.yaml").check()
    assert str(told.value) == "world.mujoco needs MuJoCo\n  pip install 'mujoco>=3.3'"


@pytest.mark.parametrize(("chosen", "needed"), [("", "OSMesa or EGL"), ("egl", "what MUJOCO_GL names, egl,")])
def test_without_a_library_to_draw_with_its_package_is_told(
    chosen: str, needed: str, maps: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(engine.CHOSEN_BY, chosen)
    monkeypatch.setattr(engine, "LIBRARIES", {"osmesa": ("libNone.so.1",), "egl": ("libNone.so.2",)})
    with pytest.raises(UserError) as told:
        Mujoco(map=maps / "empty.yaml").check()
    assert str(told.value) == f"world.mujoco needs {needed} to draw\n  apt install libosmesa6, or libegl1 libegl-mesa0"


def test_a_graph_is_refused_before_it_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(engine.CHOSEN_BY, "")
    monkeypatch.setattr(engine, "LIBRARIES", {"osmesa": ("libNone.so.1",)})
    (problem,) = check("corridor_ccw", set={"robot": "world.mujoco"})
    assert problem.what == "world.mujoco needs OSMesa or EGL to draw"


@pytest.mark.parametrize(("given", "used"), [("glfw", "glfw"), ("", "osmesa")])
def test_what_the_environment_chooses_is_kept(given: str, used: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(engine.CHOSEN_BY, given)
    monkeypatch.setattr(engine, "LIBRARIES", {"osmesa": ("libc.so.6",)})
    engine.choose_gl()
    assert os.environ[engine.CHOSEN_BY] == used


def test_neutral_surfaces_are_refused(maps: Path) -> None:
    with pytest.raises(ParamError) as told:
        Mujoco(map=maps / "empty.yaml", neutral=True).check()
    assert str(told.value) == "neutral: MuJoCo draws no neutral surfaces\n  give pictures: pymunk, or neutral: false"


def test_a_photograph_in_pictures_of_the_other_simulator_is_refused(maps: Path) -> None:
    with pytest.raises(ParamError) as told:
        Mujoco(map=maps / "empty.yaml", pictures="pymunk", floor="brick").check()
    assert str(told.value) == "floor: only MuJoCo draws photographs\n  give pictures: mujoco, or floor: map"


def test_without_the_photographs_their_package_is_told(maps: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "load", lambda: None)
    monkeypatch.setitem(sys.modules, "skimage", None)
    monkeypatch.setitem(sys.modules, "skimage.data", None)
    with pytest.raises(UserError) as told:
        Mujoco(map=maps / "empty.yaml", floor="gravel").check()
    assert str(told.value) == "floor: gravel needs scikit-image\n  pip install 'scikit-image>=0.22'"
