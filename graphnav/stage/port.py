"""Ports, read off the signature of ``step``: the signature is the schema."""

from __future__ import annotations

import inspect
import math
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Generic, NewType, TypeVar, Union, get_args, get_origin, get_type_hints

from graphnav.errors import DeclarationError
from graphnav.messages.message import Message, snake_case

Stamp = NewType("Stamp", int)
"""Annotates a parameter of ``step`` that receives the firing's time, microseconds."""

M = TypeVar("M")


@dataclass(frozen=True)
class Latest(Generic[M]):
    """A sampled input: it never triggers, and is the one legal way to close a loop.

    ``value`` is the newest message, None before the first; ``age_s`` is how old it is, infinite before the first.
    """

    value: M | None = None
    age_s: float = math.inf


@dataclass(frozen=True)
class Port:
    """One input or output: its name, its message type, whether it is sampled (`Latest`)."""

    name: str
    message: type[Message]
    latest: bool = False


@dataclass(frozen=True)
class Ports:
    """What ``step`` of a stage class takes and gives."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    stamps: tuple[str, ...]
    """Parameters that receive the stamp."""
    result: type | None
    """The NamedTuple that ``step`` returns, None where it returns one message or nothing."""


def ports_of(cls: type) -> Ports:
    """Return the ports of a stage class.

    Raises
    ------
    DeclarationError
        ``step`` is missing or its annotations do not say what comes and goes.
    """
    return _ports_of(cls)


@cache
def _ports_of(cls: Any) -> Ports:
    step = getattr(cls, "step", None)
    if not callable(step):
        raise DeclarationError(f"stage {cls.__qualname__} has no step(): write one whose annotations name its ports")
    hints = _hints(cls, step)
    inputs: list[Port] = []
    stamps: list[str] = []
    for name, parameter in list(inspect.signature(step).parameters.items())[1:]:
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
            raise DeclarationError(f"step() of {cls.__qualname__} takes '{name}': name every port, without * or /")
        hint = hints.get(name)
        if hint is Stamp:
            stamps.append(name)
            continue
        latest = get_origin(hint) is Latest
        message = get_args(hint)[0] if latest else hint
        if not _is_message(message):
            raise DeclarationError(
                f"input '{name}' of {cls.__qualname__}.step() is annotated {_written(hint)}: "
                "use a Message type, Latest[a Message type] or Stamp"
            )
        inputs.append(Port(name, message, latest))
    outputs, result = _outputs(cls, hints.get("return", inspect.Signature.empty))
    return Ports(tuple(inputs), outputs, tuple(stamps), result)


def _hints(cls: type, step: Callable[..., Any]) -> dict[str, Any]:
    try:
        return get_type_hints(step)
    except NameError as error:
        raise DeclarationError(
            f"step() of {cls.__qualname__}: {error}; import the type where the stage is defined"
        ) from error


def _outputs(cls: type, hint: Any) -> tuple[tuple[Port, ...], type | None]:
    if hint is inspect.Signature.empty:
        raise DeclarationError(
            f"step() of {cls.__qualname__} does not say what it returns: annotate it (None if nothing)"
        )
    hint = _without_none(hint)
    if hint is type(None):
        return (), None
    if _is_message(hint):
        return (Port(snake_case(hint.__name__), hint),), None
    if isinstance(hint, type) and issubclass(hint, tuple) and hasattr(hint, "_fields"):
        ports = []
        for name, field_hint in get_type_hints(hint).items():
            message = _without_none(field_hint)
            if not _is_message(message):
                raise DeclarationError(
                    f"output '{name}' of {cls.__qualname__} is {_written(message)}: use a Message type"
                )
            ports.append(Port(name, message))
        return tuple(ports), hint
    raise DeclarationError(
        f"step() of {cls.__qualname__} returns {_written(hint)}: return a Message, a NamedTuple of Messages, or None"
    )


def _without_none(hint: Any) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        rest = [a for a in get_args(hint) if a is not type(None)]
        return rest[0] if len(rest) == 1 else hint
    return type(None) if hint is None else hint


def _is_message(hint: Any) -> typing.TypeGuard[type[Message]]:
    return isinstance(hint, type) and issubclass(hint, Message)


def _written(hint: Any) -> str:
    return "nothing" if hint is None else getattr(hint, "__name__", str(hint))
