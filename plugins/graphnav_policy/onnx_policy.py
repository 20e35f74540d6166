"""A network in an ONNX file as a stage of a graph."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

from graphnav import Continuity, Latest, Message, ParamError, Stage, Stamp, param
from graphnav_policy.bound_network import BoundNetwork
from graphnav_policy.declared import Declared, as_group, ports_in, read_declared
from graphnav_policy.fit import input_problems, message_problems, output_problems
from graphnav_policy.network import Network

MAX_STEPS = 1000


class Onnx(Stage):
    """A network that was trained elsewhere, from an ONNX file: any messages in, any messages out.

    `inputs` and `outputs` say which fields of which ports the tensors of the network are; these are the ports of the
    stage. A port has the name of its message in small letters, `image` or `local_map`, with anything after `_` where
    there are two: `image_left`. Its fields are those that `graphnav.numeric_fields` gives: arrays in their own shape,
    single numbers as (1,) and float32. A batch axis of 1 is put in front, so that pixels are (1, rows, cols) and a
    single number is (1, 1); several fields in a list are one vector, (1, n). Types are converted where that loses
    nothing (uint8 to float32). Units and frames are those of the messages: what the network wants else, it computes.

    It fires when all ports hold messages of one stamp, except those in `latest`, which are sampled, and are zeros
    before their first message. After a gap of the stream, history and state restart.

    The file is read as data: no other file, no library of operators. It runs by onnxruntime (extra `onnx`) on one
    thread of the processor. The same inputs give the same bytes on one kind of processor; another one may round
    differently.

    A step fails where a message has another shape than the network takes, and where the network gives a NaN or an
    infinity. It does not limit what it gives: a robot has a guard behind it.
    """

    ports_from: ClassVar[tuple[str, ...]] = ("inputs", "outputs", "latest")

    file: Path = param(doc="the network, an ONNX file that holds all of its weights")
    inputs: Mapping[str, float | str | tuple[str, ...]] = param(
        doc="what each input of the network gets: port.field, a list of these, or a constant number (in the unit that"
        " the network takes, or dimensionless)"
    )
    outputs: Mapping[str, str | tuple[str, ...]] = param(
        doc="what each output of the network is: port.field, or a list with a field for each of its numbers"
    )
    latest: tuple[str, ...] = param(
        (), doc="input ports that are sampled: they do not fire the stage, and may close a loop"
    )
    history: Mapping[str, int] | None = param(
        None,
        ge=1,
        le=MAX_STEPS,
        doc="inputs of the network that get the last so many values along a second axis, oldest first; before there"
        " are so many, the first one is repeated",
    )
    state: Mapping[str, str] | None = param(
        None, doc="outputs of the network that are its inputs in the next step: {output: input}; zeros in the first"
    )
    constants: Mapping[str, bool | float | str] | None = param(
        None,
        doc="port.field of outputs that the network does not give, and their value (in the field's unit, or"
        " dimensionless)",
    )
    max_file_bytes: int = param(64 * 1024**2, ge=1, le=2**31 - 1, doc="a larger file is refused unread")

    @classmethod
    def with_ports(cls, **params: Any) -> type[Self]:
        """Return the class with the ports that ``inputs``, ``outputs`` and ``latest`` name."""
        problems: list[ParamError] = []
        reads, writes = (
            ports_in(read_declared(name, params[name], problems).values()) for name in ("inputs", "outputs")
        )
        latest: tuple[str, ...] = params["latest"]
        for port in latest:
            if port not in reads and not problems:
                what = f"'latest' names '{port}', which is not a port in 'inputs'"
                problems.append(ParamError("latest", what, f"ports are {', '.join(reads)}"))
        if not problems and reads.keys() <= {*latest}:
            what = "no port in 'inputs' fires the stage"
            problems.append(ParamError("inputs", what, "name a port that is not in 'latest', such as image.pixels"))
        if not problems and not writes:
            problems.append(ParamError("outputs", "'outputs' names no field", "write TENSOR: port.field"))
        for port, message in writes.items():
            if message.is_truth:
                what = f"'{port}' in 'outputs' is {message.__name__}, which is true data"
                problems.append(ParamError("outputs", what, "a network estimates: give another message"))
        as_group(problems)
        base: Any = cls
        made: Any = _with_ports(
            base, tuple((port, reads[port], port in latest) for port in reads), tuple(writes.items())
        )

        return made  # type: ignore[no-any-return]

    def check(self) -> None:
        """Check that the file is a network that onnxruntime can run, and that it fits what the graph says of it."""
        network = Network(self.file, self.max_file_bytes)
        inputs, outputs = self._declared()
        problems = [
            *input_problems(network, inputs, self.history or {}, self.state or {}, self.latest),
            *output_problems(network, outputs),
            *message_problems(ports_in(outputs.values()), outputs.values(), self.constants or {}),
        ]
        as_group(problems)

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Load the network; forget history and state."""
        inputs, outputs = self._declared()
        network = Network(self.file, self.max_file_bytes)
        self._bound = BoundNetwork(network, inputs, outputs, self.history or {}, self.state or {}, self.constants or {})
        self._continuity = Continuity()

    def step(self) -> None:
        """Never runs: the class that `with_ports` makes has a step with its ports."""

    def infer(self, stamp: Stamp, messages: Mapping[str, Message | None]) -> dict[str, Message]:
        """Return the message of each output port for those of the input ports, None for one that has not come yet.

        Raises
        ------
        ValueError
            A message has another shape than the network takes, or than the messages before it had; or the network
            fails, or gives what the message cannot hold.
        """
        if self._continuity.breaks(stamp):
            self._bound.forget()
        return self._bound.infer(messages)

    def _declared(self) -> tuple[dict[str, Declared], dict[str, Declared]]:
        problems: list[ParamError] = []
        found = read_declared("inputs", self.inputs, problems), read_declared("outputs", self.outputs, problems)
        as_group(problems)
        return found


@cache
def _with_ports(
    cls: type[Onnx], reads: tuple[tuple[str, type[Message], bool], ...], writes: tuple[tuple[str, type[Message]], ...]
) -> type[Onnx]:
    """Return a subclass whose step has these ports; ``reads``: name, message, whether it is sampled."""
    result = NamedTuple("Outputs", writes)  # type: ignore[misc]
    kinds: dict[str, Any] = {name: Latest[message] if is_sampled else message for name, message, is_sampled in reads}  # type: ignore[valid-type]
    kinds["stamp"] = Stamp

    def step(self: Onnx, stamp: Stamp, **given: Any) -> Any:
        messages = {name: one.value if isinstance(one, Latest) else one for name, one in given.items()}
        return result(**self.infer(stamp, messages))

    names = [Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)]
    names += [Parameter(name, Parameter.KEYWORD_ONLY, annotation=kind) for name, kind in kinds.items()]
    step.__annotations__ = {**kinds, "return": result}
    step.__signature__ = Signature(names, return_annotation=result)  # type: ignore[attr-defined]
    words = {"__module__": cls.__module__, "__qualname__": cls.__qualname__, "__doc__": cls.__doc__, "step": step}
    return type(cls.__name__, (cls,), words)
