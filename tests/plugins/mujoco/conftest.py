"""The maps, and what is needed to draw: tests that draw are skipped where MuJoCo or OpenGL is not installed."""

from __future__ import annotations

from pathlib import Path

import pytest
from graphnav_mujoco import engine

from graphnav import UserError

MAPS = Path(__file__).parents[3] / "graphs" / "graphnav_graphs" / "maps"


@pytest.fixture
def maps() -> Path:
    """Return the folder of the maps that ship."""
    return MAPS


@pytest.fixture(scope="session")
def drawn() -> None:
    """Skip what needs MuJoCo to draw."""
    try:
        engine.new_context(8, 8).free()
    except UserError as error:
        pytest.skip(str(error))
