"""Check the contract of a stage: call `check_stage` in the test of your own stage."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, get_args

import numpy as np

from graphnav.core.codec import encode
from graphnav.core.errors import DeclarationError, ParamError
from graphnav.core.graph import resolve_paths, shipped_folder
from graphnav.core.messages import Message
from graphnav.core.stage import (
    MAY_READ_TRUTH,
    Latest,
    Param,
    Source,
    Stage,
    Stamped,
    metrics_of,
    params_of,
    ports_of,
    reported_metrics,
    tell_readers,
    unit_of,
)

__all__ = ["check_stage"]

_NO_UNITS = (
    "ms", "sec", "secs", "second", "seconds", "meter", "meters", "metre", "metres", "cm", "mm", "km", "kmh", "degree",
    "degrees", "radian", "radians", "pixel", "pixels", "pix", "percent", "pct", "fps",
)  # fmt: skip
"""Suffixes of units that graphnav writes differently, or does not use."""


def check_stage(cls: type[Stage], *steps: Mapping[str, Any], **params: Any) -> None:
    """Check that a stage fulfils the contract of all stages.

    Its declaration can be read and is documented; its defaults fit; it can be made, reset again and again, asked for
    its metrics, all of which are declared, and closed. With ``steps`` also: the same seed gives the same outputs, these
    have the declared types and are finite where they must be, inputs are not written to, and a stage that leaves out
    what nothing reads (`Stage.is_read`) leaves out optional outputs alone and changes no other.

    Parameters
    ----------
    cls
        The stage's class.
    steps
        Keyword arguments of consecutive calls of ``step``: messages, `Latest` or stamps by name. Their arrays are made
        read-only, as those of received messages are.
    params
        Parameters that differ from the defaults, and those without one: a stage whose ports they declare
        (`Stage.ports_from`) is checked with these ports. Paths may be relative to the shipped data.

    Raises
    ------
    AssertionError
        It does not; the message says which rule is broken.
    """
    _check_declaration(cls)
    resolved = _params(cls, params)
    if resolved is None:
        return
    if cls.ports_from:
        cls = cls.with_ports(**{name: resolved[name] for name in cls.ports_from})
        _check_declaration(cls)
    first, second, unread = (cls(**resolved) for _ in range(3))
    tell_readers(unread, ())
    try:
        first.check()
    except (ParamError, ExceptionGroup) as error:
        _require(not params, cls, f"check() refuses the parameters: {error}")
        return  # its defaults name files or devices that do not exist here
    outputs = []
    for stage in (first, second, unread):
        stage.reset(seed=1)
        stage.reset(seed=1)
        _check_rate(stage)
        outputs.append([_step(stage, step) for step in steps])
        _check_summary(stage)
        stage.close()
    for number, (one, other, less) in enumerate(zip(*outputs, strict=True), start=1):
        _require(one == other, cls, f"the same seed gave a different output in step {number}")
        _check_unread(cls, one, less, number)


def _check_unread(cls: type[Stage], full: Mapping[str, Any], less: Mapping[str, Any], number: int) -> None:
    """Check what a step publishes where nothing reads any output."""
    for port in ports_of(cls).outputs:
        is_left_out = port.optional and less[port.name] is None
        what = f"output '{port.name}' of step {number} depends on which outputs are read"
        _require(is_left_out or less[port.name] == full[port.name], cls, what)


def _check_declaration(cls: type[Stage]) -> None:
    doc = inspect.getdoc(cls) or ""
    is_written = bool(doc) and not doc.startswith(f"{cls.__name__}(")  # which dataclasses write where it is missing
    _require(is_written, cls, "has no docstring; its first line is what 'graphnav stages' shows")
    _require(
        doc.splitlines()[0].endswith("."),
        cls,
        "the first line of the docstring is not a sentence: end it with a period",
    )
    ports = ports_of(cls)
    if issubclass(cls, Source):
        for port in ports.inputs:
            _require(not port.is_plain, cls, f"is a Source, but its input '{port.name}' is not sampled")
    elif ports.inputs or not cls.ports_from:
        needed = [port.name for port in ports.inputs if not port.may_be_open]
        _require(bool(needed), cls, "is not a Source and has no plain input that must be wired: nothing fires it")
    sampled = {port.name for port in ports.inputs if port.latest}
    for one in cls.unnoticed:
        _require(one.port in sampled, cls, f"names '{one.port}' in 'unnoticed', which is not a sampled input")
    for name, param in params_of(cls).items():
        _require(bool(param.doc.strip()), cls, f"parameter '{name}' has no doc")
        _check_unit(cls, param)
        if not param.required:
            try:
                param.parse(param.default)
            except ParamError as error:
                raise AssertionError(f"{cls.__qualname__}: invalid default: {error}") from error
    _check_metrics(cls)
    wanted = f'the role is {cls.role}: write role = "score" or role = "oracle"'
    for port in ports.inputs:
        may_read = not port.message.is_truth or cls.role in MAY_READ_TRUTH
        _require(may_read, cls, f"input '{port.name}' is true data, but {wanted}")


def _check_unit(cls: type[Stage], param: Param) -> None:
    is_known = param.name.rpartition("_")[2] not in _NO_UNITS
    _require(is_known, cls, f"parameter '{param.name}' does not end in a unit suffix of graphnav")
    has_unit = bool(unit_of(param.name).words) or not _has_float(param.type)
    what = f"parameter '{param.name}' has no unit suffix: add one, or say 'dimensionless' in its doc"
    _require(has_unit or "dimensionless" in param.doc, cls, what)


def _has_float(kind: Any) -> bool:
    """Return whether a parameter of this type holds floats: ``float | None`` and tuples of floats do."""
    return kind is float or any(_has_float(member) for member in get_args(kind))


def _check_metrics(cls: type[Stage]) -> None:
    declared = metrics_of(cls)
    has_summary = cls.summary is not Stage.summary
    _require(has_summary or not declared, cls, "declares metrics, but has no summary() that returns them")
    _require(bool(declared) or not has_summary, cls, "has a summary(), but declares no metrics = (Metric(...), ...)")
    for name, metric in declared.items():
        _require(name.rpartition("_")[2] not in _NO_UNITS, cls, f"metric '{name}' has no suffix of graphnav's units")
        _require(metric.help.rstrip().endswith("."), cls, f"the help of metric '{name}' is not a sentence")


def _params(cls: type[Stage], given: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return every parameter with paths resolved, None if a required one is not given."""
    params = {}
    for name, param in params_of(cls).items():
        if param.required and name not in given:
            return None
        value = param.parse(given.get(name, param.default))
        params[name] = resolve_paths(param.type, value, shipped_folder()).value
    return params


def _check_rate(stage: Stage) -> None:
    if isinstance(stage, Source):
        rate_hz = stage.rate()
        _require(math.isfinite(rate_hz) and rate_hz > 0, type(stage), f"rate() is {rate_hz}")


def _check_summary(stage: Stage) -> None:
    for name, value in stage.summary().items():
        is_number = isinstance(value, int | float | np.floating | np.integer)
        _require(isinstance(name, str) and is_number, type(stage), f"metric {name!r} of summary() is {value!r}")
    try:
        reported_metrics(stage)
    except DeclarationError as error:
        raise AssertionError(str(error)) from error


def _step(stage: Stage, given: Mapping[str, Any]) -> dict[str, bytes | None]:
    """Return the encoded output of a step by port, None for ports that it does not publish."""
    cls = type(stage)
    for value in given.values():
        _freeze(value)
    result = stage.step(**given)  # type: ignore[attr-defined]
    ports = ports_of(cls)
    values: Sequence[Any]
    if result is None:
        values = [None] * len(ports.outputs)
    elif ports.result is not None:
        _require(isinstance(result, ports.result), cls, f"step() returned {type(result).__name__}")
        values = result
    else:
        values = [result]
    published = {}
    for port, returned in zip(ports.outputs, values, strict=True):
        stamp, value = (returned.utime, returned.message) if isinstance(returned, Stamped) else (0, returned)
        if value is not None:
            _require(isinstance(value, port.message), cls, f"output '{port.name}' is {type(value).__name__}")
            bad = value.not_finite()
            _require(bad is None, cls, f"'{bad}' of output '{port.name}' is not finite")
        published[port.name] = _bytes(value, stamp)
    return published


def _bytes(value: Any, utime: int = 0) -> bytes | None:
    if isinstance(value, Latest):
        return _bytes(value.value)
    return encode(value, utime, 0) if isinstance(value, Message) else None


def _freeze(value: Any) -> None:
    message = value.value if isinstance(value, Latest) else value
    if isinstance(message, Message):
        for field in fields(message):
            array = getattr(message, field.name)
            if isinstance(array, np.ndarray):
                array.flags.writeable = False


def _require(holds: bool, cls: type, what: str) -> None:  # noqa: FBT001
    if not holds:
        raise AssertionError(f"{cls.__qualname__}: {what}")
