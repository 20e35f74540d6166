"""A type is found by its name, and nothing else is imported for that."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from graphnav.core.codec import type_named


def test_a_name_imports_no_package_that_lcm_gen_did_not_make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "innocent").mkdir()
    (tmp_path / "innocent" / "__init__.py").write_text("raise RuntimeError('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    assert type_named("innocent.pose_t") is None
    assert type_named("innocent.deep.pose_t") is None
    assert "innocent" not in sys.modules
