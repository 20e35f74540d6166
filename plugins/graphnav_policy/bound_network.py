"""A network with its inputs and outputs bound to fields of messages, with its history and its state."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from graphnav import Message, message_from, numeric_fields, numeric_layout
from graphnav_policy.declared import Declared, FieldOf, ports_in
from graphnav_policy.network import Array, Network, Tensor, shape_text


class BoundNetwork:
    """Runs a network on messages.

    ``history``: how many of the last values an input gets. ``state``: by the outputs that are fed back, the inputs that
    get them. ``constants``: values of fields of outputs, by ``port.field``.
    """

    def __init__(
        self,
        network: Network,
        inputs: Mapping[str, Declared],
        outputs: Mapping[str, Declared],
        history: Mapping[str, int],
        state: Mapping[str, str],
        constants: Mapping[str, bool | float | str],
    ) -> None:
        self._network, self._history, self._fed_back = network, history, state
        self._inputs = [one for one in inputs.values() if one.constant is None]
        self._outputs = list(outputs.values())
        self._writes = ports_in(self._outputs)
        self._constants = constants
        self._fixed = {
            one.name: _filled(network.inputs[one.name], one.constant)
            for one in inputs.values()
            if one.constant is not None
        }
        self.forget()

    def forget(self) -> None:
        """Make the state zeros, and the history empty."""
        self._state = {name: _filled(self._network.inputs[name], 0.0) for name in self._fed_back.values()}
        self._past = {name: deque[Array](maxlen=steps) for name, steps in self._history.items()}

    def infer(self, messages: Mapping[str, Message | None]) -> dict[str, Message]:
        """Return the message of each output port for those of the input ports, None for one that has not come yet.

        Raises
        ------
        ValueError
            A message does not fit the network, or the network fails or gives what the message cannot hold.
        """
        arrays = {port: None if message is None else numeric_fields(message) for port, message in messages.items()}
        feeds = {one.name: self._feed(one, arrays) for one in self._inputs}
        names = [one.name for one in self._outputs]
        found = self._network.run([*names, *self._fed_back], feeds | self._fixed | self._state)
        self._state = dict(zip(self._fed_back.values(), found[len(names) :], strict=True))
        given: dict[str, dict[str, Array]] = {port: {} for port in self._writes}
        for one, array in zip(self._outputs, found, strict=False):
            for field, part in _parts(one, array):
                given[field.port][field.name] = part
        return {port: self._message(port, arrays) for port, arrays in given.items()}

    def _feed(self, one: Declared, arrays: Mapping[str, Mapping[str, Array] | None]) -> Array:
        """Return what an input of the network gets: with the batch axis, and that of the history."""
        tensor = self._network.inputs[one.name]
        parts = [self._part(tensor, one, field, arrays[field.port]) for field in one.fields]
        array = parts[0] if len(parts) == 1 else np.concatenate([part.ravel() for part in parts])
        past = self._past.get(one.name)
        if past is not None:
            if past and past[-1].shape != array.shape:
                told = f"{_names(one)} is {shape_text(array.shape)}, and was {shape_text(past[-1].shape)} before"
                raise ValueError(f"{told}: the network's input '{one.name}' takes the last {past.maxlen}")
            past.append(array)
            array = np.stack([past[0]] * ((past.maxlen or 1) - len(past)) + [*past])
        array = array[np.newaxis].astype(tensor.dtype, copy=False)
        if not tensor.takes(array.shape):
            told = f"the network's input '{one.name}' takes {shape_text(tensor.shape)}"
            raise ValueError(f"{told}, but {_names(one)} is {shape_text(array.shape)}")
        return array

    def _part(self, tensor: Tensor, one: Declared, field: FieldOf, arrays: Mapping[str, Array] | None) -> Array:
        if arrays is not None:
            if field.name not in arrays:
                raise ValueError(f"'{field}', which the network's input '{one.name}' gets, is not given in the message")
            return arrays[field.name]
        skipped = 1 + (one.name in self._history)
        shape = tensor.shape[skipped:] if len(one.fields) == 1 else field.layout.shape or ()
        return np.zeros([length or 1 for length in shape], field.layout.dtype)

    def _message(self, port: str, arrays: Mapping[str, Array]) -> Message:
        message = self._writes[port]
        known, values, others = numeric_layout(message), dict[str, Any](arrays), dict[str, Any]()
        for word, value in self._constants.items():
            of_port, _, name = word.partition(".")
            if of_port == port:
                (values if name in known else others)[name] = value
        return message_from(message, values, **others)


def _filled(tensor: Tensor, value: float) -> Array:
    """Return an array for an input of the network; an axis of any length has length 1."""
    return np.full([length or 1 for length in tensor.shape], value, tensor.dtype)


def _parts(one: Declared, array: Array) -> Iterator[tuple[FieldOf, Array]]:
    """Yield the fields of an output with what the network gives for them."""
    if array.ndim == 0 or len(array) != 1:
        raise ValueError(f"the network's output '{one.name}' is {shape_text(array.shape)}, without a batch axis of 1")
    sizes = [int(np.prod([length or 1 for length in field.layout.shape or ()])) for field in one.fields]
    if len(one.fields) == 1:
        field, is_number = one.fields[0], one.fields[0].layout.shape == (1,)
        if not is_number or array.size == 1:
            yield field, array.reshape(1) if is_number else array[0]
            return
    if array.size != sum(sizes):
        told = f"the network's output '{one.name}' is {shape_text(array.shape)}"
        raise ValueError(f"{told}, but {_names(one)} {'are' if len(sizes) > 1 else 'is'} {sum(sizes)} numbers")
    at = 0
    for field, size in zip(one.fields, sizes, strict=True):
        yield field, array.ravel()[at : at + size].reshape([length or 1 for length in field.layout.shape or (1,)])
        at += size


def _names(one: Declared) -> str:
    return " and ".join(map(str, one.fields))
