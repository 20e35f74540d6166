"""Parse and validate the requests of a page."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

from graphnav import GraphnavError
from graphnav.watch.view.content.details import Cursor

_MAX_NAME = 1000
_ACTIONS = ("play", "pause", "seek", "step", "speed")


@dataclass(frozen=True)
class View:
    """The view of a page: the open channel, whether the map is open, the run, the cursor on the picture."""

    channel: str | None = None
    with_map: bool = False
    run_id: str | None = None
    cursor: Cursor | None = None


@dataclass(frozen=True)
class Shown:
    """Acknowledges that the page has drawn all updates up to this number."""

    number: int


@dataclass(frozen=True)
class LogCommand:
    """A playback command: "play", "pause", "seek" (s), "step" (1 or -1), "speed" (ratio)."""

    action: str
    value: float = 0.0


class RequestError(GraphnavError):
    """A page sent an invalid request."""


def parse_request(text: str | bytes) -> View | Shown | LogCommand:
    """Parse a request of a page; raises RequestError if it is invalid."""
    try:
        request = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RequestError("not JSON") from error
    if not isinstance(request, dict):
        raise RequestError("not a mapping")
    match request.get("kind"):
        case "view":
            return View(
                _name(request.get("channel")),
                request.get("map") is True,
                _name(request.get("run")),
                _cursor(request.get("cursor")),
            )
        case "shown":
            return Shown(int(_number(request.get("number"))))
        case "log" if request.get("action") in _ACTIONS:
            return LogCommand(request["action"], _number(request.get("value", 0)))
    raise RequestError("an unknown kind of request")


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
        raise RequestError("not a position")
    x_ratio, y_ratio = map(_number, value)
    return Cursor(x_ratio, y_ratio) if 0 <= x_ratio < 1 and 0 <= y_ratio < 1 else None
