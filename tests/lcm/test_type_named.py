"""A type is found by its name, and nothing else is imported for that."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.core.codec import fingerprint, type_named, type_of


def test_a_name_imports_no_package_that_lcm_gen_did_not_make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "innocent").mkdir()
    (tmp_path / "innocent" / "__init__.py").write_text("raise RuntimeError('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    assert type_named("innocent.pose_t") is None
    assert type_named("innocent.deep.pose_t") is None
    assert "innocent" not in sys.modules


def test_a_type_found_by_its_name_is_known_by_its_fingerprint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A log says the types of its channels by name: their messages decode without ``--types``."""
    (tmp_path / "buoy_t.lcm").write_text(
        "package harbour;\nstruct buoy_t { int64_t utime; int64_t seq; double depth_m; }\n"
    )
    lcm_gen = Path(sys.executable).with_name("lcm-gen")
    subprocess.run([lcm_gen, "-p", "buoy_t.lcm"], cwd=tmp_path, check=True)
    monkeypatch.syspath_prepend(tmp_path)
    lcm_class = type_named("harbour.buoy_t")
    assert lcm_class is not None
    assert type_of(fingerprint(lcm_class)) is lcm_class
