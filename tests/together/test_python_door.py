"""The names of the door: exported, documented, and imported when they are used."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import graphnav

DOOR = ("ablate", "check", "draw", "load", "open_log", "profile", "run")


@pytest.mark.parametrize("name", DOOR)
def test_every_argument_is_documented_and_typed(name: str) -> None:
    function = getattr(graphnav, name)
    text = inspect.getdoc(function) or ""
    if "The arguments are those of" not in text:
        missing = [word for word in inspect.signature(function).parameters if word not in text]
        assert missing == []
    assert all(p.annotation is not p.empty for p in inspect.signature(function).parameters.values())


@pytest.mark.parametrize("name", ["Drawing", "Log", "Profile", "Run", "Study"])
def test_every_public_attribute_is_documented(name: str) -> None:
    cls = getattr(graphnav, name)
    public = {word: value for word, value in vars(cls).items() if not word.startswith("_")}
    assert [word for word, value in public.items() if not inspect.getdoc(value)] == []


def test_importing_graphnav_loads_nothing_heavy() -> None:
    code = "import sys, graphnav; print(sorted({'numpy', 'pandas', 'joblib', 'rich'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
