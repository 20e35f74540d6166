"""What every stage keeps to, as a test that anyone can call on their own."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from graphnav.codec import encode
from graphnav.errors import DeclarationError, ParamError
from graphnav.graph.find import shipped_folder
from graphnav.graph.paths import resolve_paths
from graphnav.messages import Message
from graphnav.stage import Latest, Source, Stage, Stamped, metrics_of, params_of, ports_of, reported_metrics
from graphnav.stage.metric import suffix_unit

__all__ = ["check_stage"]

_NO_UNITS = (
    "ms", "sec", "secs", "second", "seconds", "meter", "meters", "metre", "metres", "cm", "mm", "km", "kmh", "degree",
    "degrees", "radian", "radians", "pixel", "pixels", "pix", "percent", "pct", "fps",
)  # fmt: skip
"""Endings that name a unit which graphnav writes otherwise, or never."""


def check_stage(cls: type[Stage], *steps: Mapping[str, Any], **params: Any) -> None:
    """Check that a stage keeps to what every stage keeps to.

    Its declaration can be read and is documented; its defaults fit; it can be made, reset again and again, asked for
    its metrics, all of which are declared, and closed. With ``steps`` also: the same seed gives the same outputs, these
    have the declared types and are finite where they must be, and inputs are not written to.

    Parameters
    ----------
    cls
        The stage's class.
    steps
        The keyword arguments of one ``step`` after the other: messages, `Latest` or stamps by name. Their arrays become
        read-only, as received ones are.
    params
        Parameters other than the defaults. Paths of the data that ships may be relative.

    Raises
    ------
    AssertionError
        It does not; the text says what and where.
    """
    _check_declaration(cls)
    resolved = _params(cls, params)
    if resolved is None:
        return
    first, second = cls(**resolved), cls(**resolved)
    try:
        first.check()
    except ParamError as error:
        _require(not params, cls, f"check() refuses the parameters: {error}")
        return  # its defaults name files or devices that are not here
    outputs = []
    for stage in (first, second):
        stage.reset(seed=1)
        stage.reset(seed=1)
        _check_rate(stage)
        outputs.append([_step(stage, step) for step in steps])
        _check_summary(stage)
        stage.close()
    for number, (one, other) in enumerate(zip(*outputs, strict=True), start=1):
        _require(one == other, cls, f"the same seed gave another output in step {number}")


def _check_declaration(cls: type[Stage]) -> None:
    doc = inspect.getdoc(cls) or ""
    is_written = bool(doc) and not doc.startswith(f"{cls.__name__}(")  # as dataclasses write where it is missing
    _require(is_written, cls, "has no docstring; its first line is what 'graphnav stages' shows")
    _require(doc.splitlines()[0].endswith("."), cls, "the docstring's first line is no sentence")
    ports = ports_of(cls)
    plain = [port.name for port in ports.inputs if port.is_plain]
    if issubclass(cls, Source):
        _require(not plain, cls, f"is a Source, but its input '{plain[:1]}' is not sampled")
    else:
        needed = [port.name for port in ports.inputs if not port.may_be_open]
        _require(bool(needed), cls, "is no Source and has no plain input that must be wired: nothing fires it")
    for name, param in params_of(cls).items():
        _require(bool(param.doc.strip()), cls, f"parameter '{name}' has no doc")
        _require(name.rpartition("_")[2] not in _NO_UNITS, cls, f"parameter '{name}' has no suffix of graphnav's units")
        if not param.required:
            try:
                param.parse(param.default)
            except ParamError as error:
                raise AssertionError(f"{cls.__qualname__}: the default does not fit: {error}") from error
    _check_metrics(cls)


def _check_metrics(cls: type[Stage]) -> None:
    declared = metrics_of(cls)
    has_summary = cls.summary is not Stage.summary
    _require(has_summary or not declared, cls, "declares metrics, but has no summary() that returns them")
    _require(bool(declared) or not has_summary, cls, "has a summary(), but declares no metrics = (Metric(...), ...)")
    for name, metric in declared.items():
        unit = suffix_unit(name) or metric.unit
        _require(metric.unit == unit, cls, f"metric '{name}' has the unit '{metric.unit}', but its name says '{unit}'")
        _require(name.rpartition("_")[2] not in _NO_UNITS, cls, f"metric '{name}' has no suffix of graphnav's units")
        _require(metric.help.rstrip().endswith("."), cls, f"the help of metric '{name}' is not a sentence")


def _params(cls: type[Stage], given: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return every parameter with paths resolved, None if one is needed that is not given."""
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
    """Return the bytes of what a step publishes, by port, None for what it does not."""
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
