"""Spaces of Gymnasium for the messages of channels: their bounds, and arrays to and from messages."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from graphnav import (
    BaseLimits,
    FieldError,
    GraphnavError,
    Latest,
    Message,
    Twist,
    UserError,
    message_from,
    numeric_fields,
)
from graphnav.core.graph import Channel
from graphnav.learning.interface import Interface, Observed, numeric_of

Array = npt.NDArray[Any]
Values = Array | dict[str, Array]
_FINITE = float(np.finfo(np.float32).max)
_MASKS = ("valid", "obstacle")
_BY_UNIT = {"rad": math.pi, "ratio": 1.0}


class Observations:
    """The arrays of what an agent observes: one alone, several by name.

    ``first``: a message of each channel, which tells the shapes.
    """

    def __init__(self, interface: Interface, first: Mapping[str, Message]) -> None:
        self._parts = [(one, field, one.key(field)) for one in interface.observed for field in one.fields]
        boxes: dict[str, spaces.Space[Any]] = {}
        for one in interface.observed:
            arrays = numeric_fields(first[one.channel.ref])
            for field in one.fields:
                boxes[one.key(field)] = _box(one, field, arrays[field])
        self._is_alone = len(boxes) == 1
        self.space: spaces.Space[Any] = next(iter(boxes.values())) if self._is_alone else spaces.Dict(boxes)
        self._boxes = boxes

    def read(self, inputs: Mapping[str, Any]) -> Values:
        """Return new arrays of the inputs of an agent; zeros for a sampled channel without a message yet.

        Raises
        ------
        GraphnavError
            An array has not the shape of the space.
        """
        arrays: dict[str, dict[str, Array]] = {}
        found: dict[str, Array] = {}
        for one, field, key in self._parts:
            if one.port not in arrays:
                given = inputs[one.port]
                message = given.value if isinstance(given, Latest) else given
                arrays[one.port] = {} if message is None else numeric_fields(message)
            shape, dtype = self._boxes[key].shape, self._boxes[key].dtype
            array = arrays[one.port].get(field)
            if array is not None and array.shape != shape:
                raise GraphnavError(
                    f"'{field}' of '{one.channel.ref}' has the shape {array.shape} in this world, but the observation "
                    f"space {shape}: name other fields in observe"
                )
            found[key] = np.zeros(shape or (), dtype) if array is None else array.copy()
        return found[self._parts[0][2]] if self._is_alone else found


def _box(one: Observed, field: str, array: Array) -> spaces.Box:
    if not array.size:
        raise UserError.of(
            f"observe: '{field}' of '{one.channel.ref}' is empty in this world",
            f"name the others: {', '.join(f'{one.channel.ref}.{name}' for name in one.fields if name != field)}",
        )
    if array.dtype.kind in "iub":
        high = 1 if array.dtype.kind == "b" or (field in _MASKS and array.dtype == np.uint8) else None
        info = None if array.dtype.kind == "b" else np.iinfo(array.dtype)
        top = high if high is not None else info.max if info is not None else 1
        return spaces.Box(0 if info is None or info.min == 0 else info.min, top, array.shape, array.dtype.type)
    declared = {f.name: f for f in fields(one.channel.message)}[field]
    limit = _FINITE if declared.metadata.get("finite", True) else math.inf
    return spaces.Box(-limit, limit, array.shape, np.float32)


class Actions:
    """The message that an agent publishes, as an array or, where it holds arrays, as several by name.

    ``first``: a message of the replaced stage, whose shapes and other fields it takes; None for one of scalars alone.
    ``bounds``: of fields, lowest and highest. ``normalized``: floats of the action are from -1 to 1 in their place.
    """

    def __init__(
        self,
        channel: Channel,
        first: Message | None,
        bounds: Mapping[str, tuple[float, float]],
        *,
        normalized: bool = False,
    ) -> None:
        self._class = channel.message
        names = numeric_of(channel)
        arrays = {} if first is None else {name: a for name, a in numeric_fields(first).items() if name in names}
        self._arrays = arrays or {name: np.zeros(1, np.float32) for name in names}
        self._others = {} if first is None else {f.name: getattr(first, f.name) for f in fields(self._class)}
        self._is_flat = all(array.shape == (1,) and array.dtype == np.float32 for array in self._arrays.values())
        boxes = {name: _action_box(name, array, bounds.get(name)) for name, array in self._arrays.items()}
        self._scales = {
            name: (box.low.astype(np.float64), (box.high - box.low).astype(np.float64) / 2)
            for name, box in boxes.items()
            if normalized and np.dtype(box.dtype).kind == "f"
        }
        for name in self._scales:
            boxes[name] = spaces.Box(-1.0, 1.0, boxes[name].shape, np.float32)
        self.space: spaces.Space[Any] = spaces.Dict(dict(boxes))
        if self._is_flat:
            low, high = (np.concatenate([getattr(box, end) for box in boxes.values()]) for end in ("low", "high"))
            self.space = spaces.Box(low, high, dtype=np.float32)

    def message(self, action: Any) -> Message:
        """Return the message of an action.

        Raises
        ------
        UserError
            It is not of the space's form, or not finite. Values beyond the bounds are the world's to limit.
        """
        if self._is_flat:
            array = checked_array("the action", action, (len(self._arrays),))
            parts: dict[str, Array] = {name: array[place : place + 1] for place, name in enumerate(self._arrays)}
        else:
            if not isinstance(action, Mapping) or set(action) != set(self._arrays):
                said = (
                    f"the keys {', '.join(map(str, action))}" if isinstance(action, Mapping) else type(action).__name__
                )
                raise UserError.of(f"the action has {said}", f"give arrays named {', '.join(self._arrays)}")
            parts = {
                name: checked_array(f"'{name}' of the action", action[name], a.shape)
                for name, a in self._arrays.items()
            }
        for name, (low, half) in self._scales.items():
            parts[name] = low + (parts[name] + 1.0) * half
        try:
            return message_from(self._class, parts, **self._others)
        except FieldError as error:
            raise UserError.of(f"the action: {error}", "give numbers of the action space") from error


def _action_box(name: str, array: Array, bounds: tuple[float, float] | None) -> spaces.Box:
    if array.dtype.kind in "iub":
        top = 1 if name in _MASKS or array.dtype.kind == "b" else np.iinfo(array.dtype).max
        return spaces.Box(0, top, array.shape, array.dtype.type)
    limit = next((limit for unit, limit in _BY_UNIT.items() if name.endswith(f"_{unit}")), 1.0)
    low, high = bounds or (0.0 if name.endswith("_ratio") else -limit, limit)
    return spaces.Box(low, high, array.shape, np.float32)


def checked_array(who: str, given: Any, shape: tuple[int, ...]) -> Array:
    """Return an array of finite numbers of a shape; raise UserError, of ``who``, for anything else."""
    hint = f"give an array of {shape} numbers"
    try:
        array = np.asarray(given)
    except (ValueError, TypeError) as error:
        raise UserError.of(f"{who} is not an array: {error}", hint) from error
    if array.dtype.kind not in "biuf":
        raise UserError.of(f"{who} is of {array.dtype if array.dtype.kind != 'O' else type(given).__name__}", hint)
    if array.shape != shape:
        raise UserError.of(f"{who} has the shape {array.shape}", hint)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise UserError.of(f"{who} holds a NaN or an infinity", "clip what the policy gives to the action space")
    return array


def twist_bounds(limits: BaseLimits | None, guards: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Return the bounds of a twist by field, of what the base declares and the guards' parameters, the lower ones.

    Raises
    ------
    UserError
        Neither gives a limit.
    """
    found = {}
    for field, name in zip((f.name for f in fields(Twist)), ("max_speed_mps", "max_turn_radps"), strict=True):
        given = [guards.get(name), None if limits is None else getattr(limits, name)]
        known = [limit for limit in given if limit is not None]
        if not known:
            what = f"nothing tells the {name} of the robot, so the action has no bounds"
            raise UserError.of(what, f"set it on the guard: set={{'guard.{name}': 1.0}}")
        found[field] = (-min(known), min(known))
    return found
