"""The shipped LCM types: fresh, distinct, enveloped, and understood by lcm-gen's own Python."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import graphnav_lcm
import numpy as np
import pytest

from graphnav.core import messages
from graphnav.core.codec import (
    SHIPPED,
    codec_of,
    decode,
    encode,
    fields_of,
    fingerprint,
    lcm_name,
    lcm_text_of,
    type_named,
    type_of,
)
from graphnav.core.messages import Message
from graphnav.core.typeinfo import nested_types

from .conftest import TOOLS

ROOT = Path(__file__).resolve().parents[2]
NESTED = {nested for lcm_class in SHIPPED for nested in nested_types(lcm_class)}
TOP = [lcm_class for lcm_class in SHIPPED if lcm_class not in NESTED]
"""Published types; nested structs have neither a message nor an envelope."""
MESSAGES = [found for found in vars(messages).values() if isinstance(found, type) and issubclass(found, Message)]
MESSAGES.remove(Message)

RNG = np.random.default_rng(5)
SIZES = {
    name: size
    for size, name in enumerate(
        (
            "rows",
            "cols",
            "n_bodies",
            "n_vertices",
            "n_goal",
            "n_footprint",
            "n_moving",
            "n_channels",
            "n_terms",
            "n_stages",
            "n_inputs",
            "n_outputs",
            "n_edges",
            "n_reasons",
            "n_causes",
        ),
        start=2,
    )
}
VALUES: dict[str, Any] = {"string": "naïve", "boolean": True, "float": 1.5, "double": -2.5, "byte": 200}


def filled(lcm_class: Any) -> Any:
    """Return an lcm-gen object with something other than 0 in every field: a ``step_px`` of 0 is read as 1."""
    made = lcm_class()
    if lcm_class is graphnav_lcm.image_t:
        made.rows, made.cols, made.channels, made.size = 2, 3, 3, 18
    for name, typename, dims, struct in fields_of(lcm_class):
        value = filled(struct) if struct else VALUES.get(typename, int(RNG.integers(1, 100)))
        if not dims:
            if lcm_class is not graphnav_lcm.image_t or name in ("utime", "seq", "step_px"):
                setattr(made, name, SIZES.get(name, value))
            continue
        for dim in reversed(dims):
            size = getattr(made, dim) if isinstance(dim, str) else dim
            value = [value] * size
        setattr(made, name, value)
    if lcm_class in (graphnav_lcm.floor_map_t, graphnav_lcm.local_map_t):
        made.cell_m, made.state = 0.5, [[3] * made.cols] * made.rows
    if lcm_class is graphnav_lcm.scan_t:
        made.angle_increment_rad, made.range_min_m, made.range_max_m = 0.01, 0.1, 9.0
    if lcm_class is graphnav_lcm.camera_info_t:
        made.model, made.n_distortion, made.distortion = "plumb_bob", 5, [0.25] * 5
        made.camera = [[2.5] * 3] * 3
    if lcm_class is graphnav_lcm.base_limits_t:
        for name in made.__slots__[2:]:
            setattr(made, name, 2.5)
    return made


def test_the_generated_code_is_fresh() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "tools/gen_lcm.py", "--check"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_definition_has_its_class() -> None:
    assert {lcm_class.__name__ for lcm_class in SHIPPED} == {p.stem for p in (ROOT / "lcmtypes").glob("*.lcm")}


def test_all_fingerprints_differ() -> None:
    assert len({fingerprint(lcm_class) for lcm_class in SHIPPED}) == len(SHIPPED)


def test_every_type_has_a_message_and_every_message_its_type() -> None:
    wrapped = {kind for message in MESSAGES for kind in (message.lcm_class, *message.former_lcm_classes)}
    assert wrapped == set(TOP)


@pytest.mark.parametrize("lcm_class", TOP, ids=lcm_name)
def test_the_envelope_comes_first(lcm_class: Any) -> None:
    assert lcm_class.__slots__[:2] == ["utime", "seq"]
    assert lcm_class.__typenames__[:2] == ["int64_t", "int64_t"]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: str(message.__name__))
def test_every_message_crosses_lcm_and_comes_back(message: type[Message]) -> None:
    theirs = filled(message.lcm_class).encode()
    utime, seq, decoded = decode(message, theirs)
    ours = encode(decoded, utime, seq)
    assert ours == theirs
    again: Any = getattr(message.lcm_class, "decode")(ours)  # noqa: B009 - lcm-gen's classes are not typed
    assert (again.utime, again.seq) == (utime, seq)
    assert again.encode() == theirs


@pytest.mark.parametrize("lcm_class", SHIPPED, ids=lcm_name)
def test_a_type_is_found_by_name_and_by_fingerprint(lcm_class: Any) -> None:
    assert type_named(lcm_name(lcm_class)) is lcm_class
    assert type_of(filled(lcm_class).encode()) is lcm_class


@pytest.mark.parametrize("name", ["graphnav_lcm.nothing_t", "nowhere.flow_t", "flow_t", "", "os.path", "..flow_t"])
def test_a_type_that_is_not_there_is_none(name: str) -> None:
    assert type_named(name) is None


def test_bytes_of_no_known_type_are_none() -> None:
    assert type_of(b"") is None
    assert type_of(bytes(40)) is None


def test_the_text_of_types_makes_the_same_types(codec_types: ModuleType, tmp_path: Path) -> None:
    lcm_classes = [*SHIPPED, codec_types.every_t, codec_types.tree_t]
    renamed = re.sub(r"\b(codec_types|graphnav_lcm)\b", r"again_\1", lcm_text_of(lcm_classes))
    for number, text in enumerate(renamed.split("package ")[1:]):
        (tmp_path / f"{number}.lcm").write_text(f"package {text}")
    files = map(str, sorted(tmp_path.glob("*.lcm")))
    subprocess.run([str(TOOLS / "lcm-gen"), "-p", "--ppath", str(tmp_path), *files], check=True)
    sys.path.insert(0, str(tmp_path))
    try:
        importlib.import_module("again_codec_types.deep")
        for lcm_class in lcm_classes:
            package, _, name = lcm_name(lcm_class).rpartition(".")
            made = getattr(importlib.import_module(f"again_{package}"), name)
            assert fingerprint(made) == fingerprint(lcm_class)
            assert codec_of(made).fields == codec_of(lcm_class).fields
    finally:
        sys.path.remove(str(tmp_path))
