"""A type is found by the fingerprint of a message, also one that was not known before."""

from __future__ import annotations

import subprocess
import sys
import uuid
from pathlib import Path

import pytest

from graphnav.core.codec import fingerprint, known_types, type_of
from graphnav.core.messages import Message
from graphnav.core.typeinfo import load_types

from .conftest import TOOLS


def generated(folder: Path, package: str) -> type:
    """Let lcm-gen write a package with one type that no other test has, and import it."""
    definition = folder / f"{package}.lcm"
    definition.write_text(f"package {package};\nstruct one_t\n{{\n    int64_t utime, seq, {package};\n}}\n")
    subprocess.run([TOOLS / "lcm-gen", "-p", "--ppath", folder, definition], check=True)
    sys.path.insert(0, str(folder))
    try:
        found: type = __import__(package).one_t
    finally:
        sys.path.remove(str(folder))
    return found


@pytest.fixture
def package() -> str:
    """Return a name that no other test uses: what is made known stays known in this process."""
    return f"p{uuid.uuid4().hex[:12]}"


def test_every_known_type_is_found_and_no_other() -> None:
    for lcm_class in known_types():
        found = type_of(fingerprint(lcm_class) + b"more")
        assert found is not None
        assert fingerprint(found) == fingerprint(lcm_class)
    assert type_of(b"") is None
    assert type_of(b"unknown!") is None


def test_a_message_class_that_is_declared_later_is_found(tmp_path: Path, package: str) -> None:
    lcm_class = generated(tmp_path, package)
    data = fingerprint(lcm_class)
    assert type_of(data) is None
    declared = type("One", (Message,), {"__annotations__": {package: int}, "__module__": __name__}, lcm=lcm_class)
    assert type_of(data) is lcm_class
    del declared


def test_a_type_that_is_loaded_later_is_found(tmp_path: Path, package: str) -> None:
    lcm_class = generated(tmp_path, package)
    data = fingerprint(lcm_class)
    assert type_of(data) is None
    load_types([str(tmp_path)])
    found = type_of(data)
    assert found is not None
    assert fingerprint(found) == data
