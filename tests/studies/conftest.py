"""Studies, all of which have the same workers."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _one_pool(study_workers: None) -> None:
    """Start no worker twice."""
