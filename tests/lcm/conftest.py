"""What the LCM tests share: test types made by lcm-gen, and a multicast group of their own."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import lcm
import pytest

TOOLS = Path(lcm.LCM_BIN_DIR)
"""LCM's tools themselves: the scripts of the same names are Python programs that leave them behind when stopped."""
TYPES = sorted((Path(__file__).parent / "types").glob("*.lcm"))


@pytest.fixture(scope="session")
def codec_types(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """Return the package that lcm-gen makes of the types beside this file."""
    folder = tmp_path_factory.mktemp("lcm")
    subprocess.run([TOOLS / "lcm-gen", "-p", "--ppath", folder, *TYPES], check=True)
    sys.path.insert(0, str(folder))
    importlib.import_module("codec_types.deep")
    yield importlib.import_module("codec_types")
    sys.path.remove(str(folder))
