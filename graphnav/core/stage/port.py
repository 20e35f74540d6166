"""Derive ports from the signature of ``step``."""

from __future__ import annotations

import inspect
import math
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Generic, NewType, TypeVar, Union, get_args, get_origin, get_type_hints

from graphnav.core.codec import check_fields
from graphnav.core.errors import DeclarationError
from graphnav.core.messages.message import Message, snake_case

Stamp = NewType("Stamp", int)
"""Annotates a parameter of ``step`` that receives the time of the firing in microseconds."""

Age = NewType("Age", float)
"""Annotates a parameter of ``step`` that receives the age of the plain inputs in seconds.

0 in lockstep. In a live run it is measured from the arrival of the input that they derive from, and grows from one
timer firing (``every_ms``) to the next; infinite before the first complete set.
"""

M = TypeVar("M")


@dataclass(frozen=True)
class Latest(Generic[M]):
    """A sampled input: it never triggers, and is the only way to close a loop.

    ``value`` is the newest message, None before the first; ``age_s`` is how old it is, infinite before the first.
    ``fault``: in a live run, the fault in the stamps of the input that feeds it, empty if there is none.
    ``is_connected``: whether the graph wires it.
    """

    value: M | None = None
    age_s: float = math.inf
    fault: str = ""
    is_connected: bool = True


@dataclass(frozen=True)
class Since(Generic[M]):
    """An input that holds all messages since the last firing, for senders of another rate; it never triggers.

    ``messages``: pairs of the sender's stamp (microseconds) and the message, oldest first. In a live run a firing
    waits, for at most `Stage.patience_s`, for a message as new as the firing's stamp.
    """

    messages: tuple[tuple[int, M], ...] = ()


@dataclass(frozen=True)
class Stamped(Generic[M]):
    """An output with its own stamp, as of a sensor that does not sample at the stage's firings.

    The field of the NamedTuple that ``step`` returns is annotated ``Stamped[T]``, or ``Stamped[T] | None``. Its channel
    may feed `Latest` and `Since` inputs, inputs of other programs and logs, but no plain input.
    """

    message: M
    utime: int


@dataclass(frozen=True)
class Port:
    """An input or output: its name, message type and how it is read.

    ``latest``: sampled (`Latest`). ``since``: holds all messages since the last firing (`Since`). ``optional``: a
    plain input annotated ``T | None``, which a timer may fire before there is a message, or an output that a step may
    omit. ``defaulted``: a plain input declared ``T | None = None``. ``stamped``: an output with its own stamps
    (`Stamped`).
    """

    name: str
    message: type[Message]
    latest: bool = False
    since: bool = False
    optional: bool = False
    defaulted: bool = False
    stamped: bool = False

    @property
    def is_plain(self) -> bool:
        """Whether a message on it fires the stage."""
        return not (self.latest or self.since)

    @property
    def may_be_open(self) -> bool:
        """Whether a graph may leave it unwired."""
        return self.defaulted or not self.is_plain

    @property
    def reading(self) -> str:
        """How it is read: "latest", "since", or empty for a plain input."""
        return "latest" if self.latest else "since" if self.since else ""


@dataclass(frozen=True)
class Ports:
    """The inputs and outputs of ``step`` of a stage class."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    stamps: tuple[str, ...]
    """Parameters that receive the stamp."""
    ages: tuple[str, ...]
    """Parameters that receive the age of the plain inputs."""
    result: type | None
    """The NamedTuple that ``step`` returns, None where it returns one message or nothing."""


def ports_of(cls: type) -> Ports:
    """Return the ports of a stage class.

    Raises
    ------
    DeclarationError
        ``step`` is missing, its annotations do not name the ports, or a message class among them does not have the
        fields of its LCM type.
    """
    return _ports_of(cls)


@cache
def _ports_of(cls: Any) -> Ports:
    step = getattr(cls, "step", None)
    if not callable(step):
        raise DeclarationError(f"stage {cls.__qualname__} has no step(): add one whose annotations name its ports")
    hints = _hints(cls, step)
    inputs: list[Port] = []
    stamps: list[str] = []
    ages: list[str] = []
    for name, parameter in list(inspect.signature(step).parameters.items())[1:]:
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
            raise DeclarationError(f"step() of {cls.__qualname__} takes '{name}': name every port, without * or /")
        hint = hints.get(name)
        if hint is Stamp:
            stamps.append(name)
            continue
        if hint is Age:
            ages.append(name)
            continue
        latest, since = get_origin(hint) is Latest, get_origin(hint) is Since
        message = get_args(hint)[0] if latest or since else _without_none(hint)
        if not _is_message(message):
            raise DeclarationError(
                f"input '{name}' of {cls.__qualname__}.step() is annotated {_written(hint)}: "
                "use a Message type, Latest[...] or Since[...] of one, Stamp or Age"
            )
        optional = not (latest or since) and message is not hint
        defaulted = optional and parameter.default is None
        inputs.append(Port(name, message, latest, since, optional, defaulted))
    outputs, result = _outputs(cls, hints.get("return", inspect.Signature.empty))
    for port in (*inputs, *outputs):
        check_fields(port.message)
    return Ports(tuple(inputs), outputs, tuple(stamps), tuple(ages), result)


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
    returned, hint = hint, _without_none(hint)
    may_be_silent = hint is not returned
    if hint is type(None):
        return (), None
    if _is_message(hint):
        return (Port(snake_case(hint.__name__), hint, optional=may_be_silent),), None
    if isinstance(hint, type) and issubclass(hint, tuple) and hasattr(hint, "_fields"):
        ports = []
        for name, field_hint in get_type_hints(hint).items():
            message = _without_none(field_hint)
            optional = may_be_silent or message is not field_hint
            stamped = get_origin(message) is Stamped
            if stamped:
                message = get_args(message)[0]
            if not _is_message(message):
                raise DeclarationError(
                    f"output '{name}' of {cls.__qualname__} is {_written(message)}: use a Message type"
                )
            ports.append(Port(name, message, optional=optional, stamped=stamped))
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
