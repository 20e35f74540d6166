"""What a page asks for, checked: a browser may send anything."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from graphnav.errors import GraphnavError
from graphnav.view.content.details import Cursor

_MAX_NAME = 1000
_ACTIONS = ("play", "pause", "seek", "step", "speed")


@dataclass(frozen=True)
class View:
    """What is on a page: the channel that is open, whether the map is, the run, where the cursor is on the picture."""

    channel: str | None = None
    with_map: bool = False
    run_id: str | None = None
    cursor: Cursor | None = None


@dataclass(frozen=True)
class Shown:
    """The page has drawn everything up to an update of this number."""

    number: int


@dataclass(frozen=True)
class LogCommand:
    """What to do with the log: "play", "pause", "seek" (s), "step" (1 or -1), "speed" (ratio)."""

    action: str
    value: float = 0.0


class RequestError(GraphnavError):
    """What came is not an order."""


def parse_request(text: str | bytes) -> View | Shown | LogCommand:
    """Return what a page sent; raises RequestError for anything else."""
    try:
        said = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RequestError("not JSON") from error
    if not isinstance(said, dict):
        raise RequestError("not a mapping")
    match said.get("kind"):
        case "view":
            return View(
                _name(said.get("channel")), said.get("map") is True, _name(said.get("run")), _cursor(said.get("cursor"))
            )
        case "shown":
            return Shown(int(_number(said.get("number"))))
        case "log" if said.get("action") in _ACTIONS:
            return LogCommand(said["action"], _number(said.get("value", 0)))
    raise RequestError("an unknown kind of order")


def _name(value: Any) -> str | None:
    if value is None or (isinstance(value, str) and len(value) <= _MAX_NAME):
        return value
    raise RequestError("not a name")


def _number(value: Any) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15 and math.isfinite(value):
        return float(value)
    raise RequestError("not a number")


def _cursor(value: Any) -> Cursor | None:
    if value is None:
        return None
    if not isinstance(value, list) or len(value) != 2:
        raise RequestError("not a place")
    x_ratio, y_ratio = map(_number, value)
    return Cursor(x_ratio, y_ratio) if 0 <= x_ratio < 1 and 0 <= y_ratio < 1 else None
