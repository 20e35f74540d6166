"""Whether a network and what a graph says of it fit, before anything runs."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import MISSING, fields

import numpy as np

from graphnav import Message, ParamError, did_you_mean
from graphnav_policy.declared import Declared, FieldOf
from graphnav_policy.network import Network, Shape, Tensor, shape_text

Constants = Mapping[str, bool | float | str]


def input_problems(
    network: Network,
    inputs: Mapping[str, Declared],
    history: Mapping[str, int],
    state: Mapping[str, str],
    latest: Collection[str],
) -> Iterator[ParamError]:
    """Yield what is wrong with ``inputs``, ``history`` and ``state``."""
    for name, tensor in network.inputs.items():
        if name not in inputs and name not in state.values():
            what = f"the network's input '{name}' {shape_text(tensor.shape)} is not declared"
            yield ParamError(
                "inputs", what, f"write {name}: port.field, or feed an output back: state: {{output: {name}}}"
            )
    yield from _unknown("inputs", inputs, network.inputs, "input")
    for name, one in inputs.items():
        if name in network.inputs:
            yield from _input_problems(network.inputs[name], one, history.get(name), latest)
    for name in history:
        if name not in inputs or not inputs[name].fields:
            hint = did_you_mean(name, inputs) or f"it has {', '.join(n for n, one in inputs.items() if one.fields)}"
            yield ParamError("history", f"'history' names '{name}', which 'inputs' does not have as fields", hint)
    yield from _unknown("state", state, network.outputs, "output")
    yield from _unknown("state", state.values(), network.inputs, "input")
    for output, name in state.items():
        if name in inputs:
            what = f"the network's input '{name}' is in 'inputs' and in 'state'"
            yield ParamError("state", what, "remove one of them")
        if output in network.outputs and name in network.inputs:
            given, taken = network.outputs[output], network.inputs[name]
            if given.dtype != taken.dtype or not taken.takes(given.shape):
                what = f"output '{output}' is {_told(given)}, but input '{name}' takes {_told(taken)}"
                yield ParamError("state", what, "feed back an output of the same type and shape")


def output_problems(network: Network, outputs: Mapping[str, Declared]) -> Iterator[ParamError]:
    """Yield what is wrong with ``outputs``."""
    yield from _unknown("outputs", outputs, network.outputs, "output")
    for name, one in outputs.items():
        if name not in network.outputs or not one.fields:
            continue
        shape = network.outputs[name].shape
        if not shape or shape[0] not in (1, None):
            what = f"the network's output '{name}' is {shape_text(shape)}, without a batch axis of 1"
            yield ParamError("outputs", what, "export it with a first axis of length 1")
        elif len(one.fields) == 1:
            yield from _one_field(name, shape, one.fields[0])
        else:
            yield from _many_fields(name, shape, one.fields)


def message_problems(
    writes: Mapping[str, type[Message]], outputs: Iterable[Declared], constants: Constants
) -> Iterator[ParamError]:
    """Yield the fields of messages that neither the network nor ``constants`` give, or both or neither have."""
    given = [str(field) for one in outputs for field in one.fields]
    for word in sorted({word for word in given if given.count(word) > 1}):
        yield ParamError("outputs", f"'{word}' is given twice", "keep one")
    for word in constants:
        port, _, name = word.partition(".")
        names = [field.name for field in fields(writes[port])] if port in writes else []
        known = [f"{p}.{field.name}" for p, message in writes.items() for field in fields(message)]
        if name not in names:
            hint = did_you_mean(word, known) or f"fields are {', '.join(known)}"
            yield ParamError("constants", f"'{word}' in 'constants' is not a field of an output", hint)
        elif word in given:
            yield ParamError("constants", f"'{word}' is given by the network and in 'constants'", "remove one of them")
    for port, message in writes.items():
        required = [f for f in fields(message) if f.default is MISSING and f.default_factory is MISSING]
        missing = [word for f in required if (word := f"{port}.{f.name}") not in given and word not in constants]
        if missing:
            words = ", ".join(f"'{word}'" for word in missing)
            what = f"every {message.__name__} has {words}, which the network does not give"
            yield ParamError(
                "outputs", what, f"write outputs: {{TENSOR: {missing[0]}}}, or constants: {{{missing[0]}: ...}}"
            )


def _unknown(param: str, names: Iterable[str], known: Mapping[str, Tensor], kind: str) -> Iterator[ParamError]:
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known) or f"it has {', '.join(known) or 'none'}"
            yield ParamError(param, f"the network has no {kind} '{name}'", hint)


def _input_problems(tensor: Tensor, one: Declared, steps: int | None, latest: Collection[str]) -> Iterator[ParamError]:
    name = tensor.name
    if one.constant is not None:
        return
    for field in one.fields:
        if not np.can_cast(field.layout.dtype, tensor.dtype, "safe"):
            what = f"the network's input '{name}' is {tensor.dtype}, which cannot hold '{field}', {field.layout.dtype}"
            yield ParamError("inputs", what, f"export it with an input of {field.layout.dtype}")
    shape = input_shape(one, steps)
    if shape is not None and not tensor.takes(shape):
        told = " and ".join(map(str, one.fields)) + (f", the last {steps}," if steps else "")
        what = f"the network's input '{name}' takes {shape_text(tensor.shape)}, but {told} is {shape_text(shape)}"
        yield ParamError("inputs", what, "export it with this shape, or declare other fields or another 'history'")
    elif shape is None and (len(tensor.shape) < 2 + bool(steps) or tensor.shape[0] not in (1, None)):
        what = f"the network's input '{name}' takes {shape_text(tensor.shape)}, without a batch axis of 1"
        yield ParamError("inputs", what, "export it with a first axis of length 1")
    elif shape is None and steps and tensor.shape[1] not in (steps, None):
        what = (
            f"the network's input '{name}' takes {shape_text(tensor.shape)}, whose second axis is not the last {steps}"
        )
        yield ParamError("history", what, f"write history: {{{name}: {tensor.shape[1]}}}, or leave it out")
    for field in one.fields:
        shape = tensor.shape[1 + bool(steps) :] if len(one.fields) == 1 else field.layout.shape
        if field.port in latest and (shape is None or None in shape):
            what = f"'{field}' is sampled, but how many zeros '{name}' gets before the first message is not known"
            yield ParamError(
                "latest", what, f"export '{name}' with a fixed shape, or let '{field.port}' fire the stage"
            )


def input_shape(one: Declared, steps: int | None) -> tuple[int | None, ...] | None:
    """Return the shape of what a tensor is given, with the batch axis, None where its rank is not known."""
    shapes = [field.layout.shape for field in one.fields]
    shape: Shape | None = shapes[0] if shapes else None
    if len(shapes) > 1:
        sizes = [None if found is None else _size(found) for found in shapes]
        shape = (None if None in sizes else sum(size for size in sizes if size is not None),)
    if shape is None:
        return None
    return (1, *((steps,) if steps else ()), *shape)


def _size(shape: Shape) -> int | None:
    return None if None in shape else math.prod(length for length in shape if length is not None)


def _one_field(name: str, shape: Shape, field: FieldOf) -> Iterator[ParamError]:
    wanted = field.layout.shape
    if wanted == (1,):
        if _size(shape[1:]) not in (1, None):
            what = f"the network's output '{name}' is {shape_text(shape)}, but '{field}' is one number"
            yield ParamError("outputs", what, f"write {name}: [port.field, ...], a field for each number")
    elif wanted is not None and not Tensor(name, field.layout.dtype, (1, *wanted)).takes(shape):
        what = f"the network's output '{name}' is {shape_text(shape)}, but '{field}' is {shape_text((1, *wanted))}"
        yield ParamError("outputs", what, "export it with this shape")


def _many_fields(name: str, shape: Shape, named: tuple[FieldOf, ...]) -> Iterator[ParamError]:
    open_ended = [field for field in named if field.layout.shape is None or _size(field.layout.shape) is None]
    if open_ended:
        what = f"'{name}' in 'outputs' is a list, but '{open_ended[0]}' is an array of any length"
        yield ParamError("outputs", what, "give it an output of the network of its own")
        return
    size = sum(_size(field.layout.shape or ()) or 0 for field in named)
    if _size(shape[1:]) not in (size, None):
        told = " and ".join(map(str, named))
        what = f"the network's output '{name}' is {shape_text(shape)}, but {told} are {size} numbers"
        yield ParamError("outputs", what, "name a field for each number")


def _told(tensor: Tensor) -> str:
    return f"{tensor.dtype} {shape_text(tensor.shape)}"
