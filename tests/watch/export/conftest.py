"""Fixtures of the export tests: a recorded drive, and additional LCM types."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import lcm
import pytest

from graphnav.core.cli import main
from graphnav.core.codec import add_type

TOOLS = Path(lcm.LCM_BIN_DIR)
TYPES = sorted((Path(__file__).parents[2] / "lcm" / "types").glob("*.lcm"))


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the run folder of two seconds of driving: 20 images, and all that is made of them."""
    folder = tmp_path_factory.mktemp("drive") / "run"
    words = ["run", "corridor_ccw", "--until", "2", "--no-tap", "--no-pictures", "--record", "all", "-o", str(folder)]
    assert main(words) == 0
    return folder


@pytest.fixture(scope="session")
def codec_types(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """Return the package that lcm-gen makes of the types of the LCM tests; logs find them by fingerprint."""
    folder = tmp_path_factory.mktemp("lcm")
    subprocess.run([TOOLS / "lcm-gen", "-p", "--ppath", folder, *TYPES], check=True)
    sys.path.insert(0, str(folder))
    importlib.import_module("codec_types.deep")
    package = importlib.import_module("codec_types")
    add_type("codec_types.every_t", package.every_t)
    yield package
    sys.path.remove(str(folder))
