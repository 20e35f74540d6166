"""Types of other packages that adapters explain: known under the names that they have in LCM."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from graphnav import Adapter, Image, Twist
from graphnav.core.catalog import Catalog
from graphnav.core.codec import codec_of, lcm_name, lcm_text_of, type_named, type_of
from graphnav.watch.feed import Received, Watch

NAME = "bot_core.image_t"


@pytest.fixture
def picture() -> bytes:
    """Return a message of a type of another package."""
    adapter = Catalog().adapters().writers[NAME]
    fields = adapter.to_lcm(Image(pixels=np.zeros((2, 3), np.uint8)), 7)
    return codec_of(adapter.lcm_class).encode(fields)


def test_spy_decodes_what_an_installed_adapter_explains(picture: bytes) -> None:
    watch = Watch()
    channel = watch.receive(Received("CAMERA", picture, 0.0))
    assert channel.type_name == NAME
    assert channel.values is not None
    assert (channel.values["width"], channel.values["height"], channel.values["utime"]) == (3, 2, 7)


def test_it_is_found_by_name_and_by_fingerprint(picture: bytes) -> None:
    found = type_of(picture)
    assert found is not None
    assert found is type_named(NAME)
    assert lcm_name(found) == codec_of(found).name == NAME


def test_its_definition_has_the_names_of_its_own_package(picture: bytes) -> None:
    found = type_of(picture)
    assert found is not None
    text = lcm_text_of([found])
    assert text.count("package bot_core;") == 2
    assert "bot_core.image_metadata_t metadata[nmetadata];" in text
    assert "graphnav" not in text


def test_a_type_may_have_another_name_than_its_class(codec_types: ModuleType) -> None:
    every: Any = codec_types.every_t

    class Renamed(Adapter):
        type_name = "base.renamed_t"
        lcm_class = codec_types.every_t
        message = Twist

    assert lcm_name(every) == "codec_types.every_t"
    assert type_named("base.renamed_t") is every


def test_an_adapter_without_a_type_of_lcm_gen_is_not_known() -> None:
    class Wrong(Adapter):
        type_name = "base.wrong_t"
        lcm_class = int
        message = Twist

    assert type_named(Wrong.type_name) is None
    assert "base" not in sys.modules
