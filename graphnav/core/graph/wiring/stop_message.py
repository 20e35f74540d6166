"""The message that stops what a motor channel moves, tried before anything runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from graphnav.core.codec import EncodeError, codec_of
from graphnav.core.errors import message_line, one_line
from graphnav.core.graph.node import OutputChannel
from graphnav.core.graph.wiring.wire_type import WireType
from graphnav.core.interrupts import CtrlC
from graphnav.core.messages import Twist


def stop_fields(
    wire: WireType | OutputChannel, stop: Mapping[str, Any] | None, utime: int = 0, seq: int = 0
) -> Mapping[str, Any]:
    """Return the fields of a stop, stamped ``utime`` (microseconds) and numbered ``seq``.

    ``stop``: the fields that the graph gives, in which stamp and number may be missing, as they may be in the type;
    None: what becomes of ``Twist(0, 0)``.

    Raises
    ------
    Exception
        Whatever the adapter raises.
    """
    twist = Twist(v_mps=0.0, omega_radps=0.0)
    if stop is None and wire.adapter is not None:
        return wire.adapter.write(twist, utime)
    if wire.ros_type is not None and stop is not None:
        return stop
    known = codec_of(wire.lcm_class).fields
    envelope = {name: value for name, value in (("utime", utime), ("seq", seq)) if name in known}
    return {**envelope, **(twist.lcm_fields() if stop is None else stop)}


def why_no_stop(wire: WireType, stop: Mapping[str, Any] | None) -> str:
    """Return why a motor output of this type cannot be stopped, empty if it can."""
    if stop is None and not issubclass(Twist, wire.message):
        return f"nothing tells how a {wire.message.__name__} stops"
    if stop is not None and (name := _not_finite(stop)):
        return f"its stop holds a NaN or an infinity in '{name}'"
    try:
        wire.codec.encode(stop_fields(wire, stop))
    except EncodeError as error:
        return f"its stop is not a {wire.name}: {message_line(error)}"
    except CtrlC:
        raise
    except BaseException as error:  # noqa: BLE001 - a plugin's adapter may raise anything
        return f"its adapter does not turn Twist(0, 0) into a {wire.name}: {one_line(error)}"
    return ""


def _not_finite(fields: Mapping[str, Any]) -> str:
    """Return the name of the first field with a number that is not finite, empty if there is none."""
    return next((name for name, value in fields.items() if not _is_finite(value)), "")


def _is_finite(value: Any) -> bool:
    if isinstance(value, Mapping):
        return not _not_finite(value)
    if isinstance(value, list):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)
