"""Ports are what the annotations of step say; what they cannot say is told."""

from typing import Any, NamedTuple

import pytest

from graphnav import DeclarationError, Flow, Image, Latest, PlanarModel, Stage, Stamp, Stamped, Twist
from graphnav.core.messages import Message
from graphnav.core.stage import Port, ports_of


class Pair(NamedTuple):
    flow: Flow
    model: PlanarModel | None


class Full(Stage):
    """Everything that a step may take and give."""

    def step(self, now: Stamp, image: Image, command: Latest[Twist]) -> Pair | None:
        return None


class Own(NamedTuple):
    flow: Stamped[Flow]
    model: Stamped[PlanarModel] | None


class Sensor(Stage):
    """Its outputs have stamps of their own."""

    def step(self, image: Image) -> Own | None:
        return None


class One(Stage):
    """A single output is named after its type."""

    def step(self, image: Image) -> PlanarModel | None:
        return None


class Sink(Stage):
    """No output."""

    def step(self, image: Image) -> None:
        return None


def test_inputs_outputs_and_stamps() -> None:
    ports = ports_of(Full)
    assert ports.inputs == (Port("image", Image), Port("command", Twist, latest=True))
    assert ports.outputs == (Port("flow", Flow, optional=True), Port("model", PlanarModel, optional=True))
    assert ports.stamps == ("now",)
    assert ports.result is Pair


def test_an_output_with_a_stamp_of_its_own_is_of_its_message() -> None:
    assert ports_of(Sensor).outputs == (
        Port("flow", Flow, optional=True, stamped=True),
        Port("model", PlanarModel, optional=True, stamped=True),
    )


def test_an_output_that_every_step_gives_is_not_optional() -> None:
    cls = type("Always", (Stage,), {"step": gives_a_pair, "__module__": __name__})
    assert ports_of(cls).outputs == (Port("flow", Flow), Port("model", PlanarModel, optional=True))


def test_a_single_output_has_the_name_of_its_type() -> None:
    assert ports_of(One).outputs == (Port("planar_model", PlanarModel, optional=True),)
    assert ports_of(Sink).outputs == ()


def wrong(step: Any) -> type[Stage]:
    return type("Wrong", (Stage,), {"step": step, "__module__": __name__})


def gives_a_pair(self: Any, image: Image) -> Pair: ...  # type: ignore[empty-body]
def takes_number(self: Any, count: int) -> Flow: ...  # type: ignore[empty-body]
def takes_nothing_said(self: Any, image) -> Flow: ...  # type: ignore[empty-body, no-untyped-def]  # noqa: ANN001
def takes_many(self: Any, *images: Image) -> Flow: ...  # type: ignore[empty-body]
def gives_nothing_said(self: Any, image: Image): ...  # type: ignore[no-untyped-def]  # noqa: ANN201
def gives_number(self: Any, image: Image) -> int: ...  # type: ignore[empty-body]
def gives_choice(self: Any, image: Image) -> Flow | Twist: ...  # type: ignore[empty-body]
def takes_unknown(self: Any, image: "Picture") -> Flow: ...  # type: ignore[empty-body, name-defined]  # noqa: F821


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (takes_number, "input 'count' of Wrong.step() is annotated int: use a Message type"),
        (takes_nothing_said, "input 'image' of Wrong.step() is annotated nothing"),
        (takes_many, "step() of Wrong takes 'images': name every port, without * or /"),
        (gives_nothing_said, "step() of Wrong does not say what it returns: annotate it"),
        (gives_number, "step() of Wrong returns int: return a Message"),
        (gives_choice, "step() of Wrong returns"),
        (takes_unknown, "name 'Picture' is not defined; import the type where the stage is defined"),
    ],
)
def test_what_cannot_be_read_is_told(step: Any, said: str) -> None:
    with pytest.raises(DeclarationError) as caught:
        ports_of(wrong(step))
    assert said in str(caught.value)


def test_a_stage_without_a_step() -> None:
    with pytest.raises(DeclarationError, match="stage Empty has no step"):
        ports_of(type("Empty", (Stage,), {}))


def test_a_field_that_is_no_parameter_is_told() -> None:
    from graphnav.core.stage import params_of

    cls = type("Wrong", (Stage,), {"__annotations__": {"alpha": float}, "alpha": 0.5})
    with pytest.raises(
        DeclarationError, match=r"field 'alpha' of Wrong is not a parameter: write alpha: \.\.\. = param"
    ):
        params_of(cls)


def test_messages_name_their_lcm_type() -> None:
    with pytest.raises(DeclarationError, match="message Bare does not name its LCM type"):
        type("Bare", (Message,), {})
