"""A separate channel for every test, a listener on it, and programs that drive and end."""

from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from .listening import Listener

Start = Callable[..., subprocess.Popen[str]]

_NUMBERS = itertools.count()


@pytest.fixture
def name() -> str:
    """Return a channel that no other test uses: the stops of an earlier one may still be on their way."""
    return f"MOTOR_{next(_NUMBERS)}"


@pytest.fixture
def listener(group: str, name: str) -> Iterator[Listener]:
    listener = Listener(group, name, f"{name}_B")
    yield listener
    listener.close()


@pytest.fixture
def drive(group: str, name: str) -> Iterator[Start]:
    """Return what starts a program that sends commands at 50 Hz and then ends in a way that has a name."""
    started: list[subprocess.Popen[str]] = []

    def start(ending: str, max_age_s: float = 5.0) -> subprocess.Popen[str]:
        command = [sys.executable, str(Path(__file__).with_name("driver.py")), group, name, str(max_age_s), ending]
        pipe = subprocess.PIPE
        process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True)
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
