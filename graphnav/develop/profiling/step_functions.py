"""Sample the Python functions that run inside of the steps, by pyinstrument, an optional package."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Problem
from graphnav.core.machine import install_command

if TYPE_CHECKING:
    from pyinstrument import Profiler
    from pyinstrument.frame import Frame

_INTERVAL_S = 1e-4
_CALLER = str(Path(__file__).with_name("tick_spans.py"))
"""The function ``timed_step`` of this file calls every stage's step."""


@dataclass
class Function:
    """A function with the functions that it called; ``share`` of the stage's step, calls included."""

    name: str
    source: str
    """File and line of its first statement, or ``built-in``."""
    share: float = 0.0
    calls: dict[tuple[str, str], Function] = field(default_factory=dict)


def functions_missing() -> Problem | None:
    """Return why functions cannot be sampled, with the command that changes it; None if they can."""
    if importlib.util.find_spec("pyinstrument") is not None:
        return None
    what = "the functions inside of the steps cannot be sampled: pyinstrument is not installed"
    return Problem(None, what, f"install it: {install_command('profile')}")


class StepFunctions:
    """Samples the call stack during steps, a tenth of a millisecond apart, in ticks in which it is on."""

    def __init__(self) -> None:
        self._profilers: dict[str, Profiler] = {}
        self.is_on = False
        """Whether the steps of this tick are sampled."""

    @contextmanager
    def on(self) -> Iterator[None]:
        """Turn it on for the block."""
        self.is_on = True
        try:
            yield
        finally:
            self.is_on = False

    @contextmanager
    def sampled(self, stage: str) -> Iterator[None]:
        """Sample a stage's step."""
        from pyinstrument import Profiler  # noqa: PLC0415 - an extra

        if stage not in self._profilers:
            self._profilers[stage] = Profiler(interval=_INTERVAL_S, async_mode="disabled")
        with self._profilers[stage]:
            yield

    def of(self, stage: str) -> list[Function]:
        """Return the functions that a stage's step runs, with shares of the step; empty if none was sampled."""
        session = self._profilers[stage].last_session if stage in self._profilers else None
        frame = session.root_frame(trim_stem=False) if session is not None else None
        if frame is None:
            return []
        top = Function("", "")
        for step in _below_caller(frame):
            _add(top, step)
        total = sum(one.share for one in top.calls.values())
        _normalize(top, total or 1.0)
        return list(top.calls.values())


def _below_caller(frame: Frame) -> Iterator[Frame]:
    """Yield the frames of a stage's step; what else its caller called begins and ends the sampling."""
    for child in frame.children:
        if frame.function == "timed_step" and frame.file_path == _CALLER:
            if child.line_no and child.function not in {"__enter__", "__exit__"}:
                yield child
        else:
            yield from _below_caller(child)


def _add(caller: Function, frame: Frame) -> None:
    """Add a frame's time, and that of all it called, to the function of the same name and source."""
    path = frame.file_path or ""
    is_python = path.endswith(".py")
    source = f"{Path(path).parent.name}/{Path(path).name}:{frame.line_no}" if is_python else "built-in"
    name = f"{frame.class_name}.{frame.function}" if frame.class_name else frame.function
    function = caller.calls.setdefault((name, source), Function(name, source))
    function.share += frame.time
    for child in frame.children:
        if not child.is_synthetic:
            _add(function, child)


def _normalize(function: Function, total: float) -> None:
    for one in function.calls.values():
        one.share /= total
        _normalize(one, total)
