"""Declared files: values are read with their types, and all problems are reported at once, each at its place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav import FileFormat, Range, Record, Value, key
from graphnav.core.errors import DeclarationError, Place, UserError
from graphnav.core.spec import keys_of


class Spot(NamedTuple):
    x: Range[float]
    y: Range[float]


class Lamp(Record):
    noun = "a lamp"

    at_m: Spot = key(doc="where it is")
    power_w: Range[float] = key(Range(40.0, 40.0), gt=0.0, le=100.0, doc="what it takes")


class Door(Record):
    noun = "a door"
    renamed: ClassVar[Mapping[str, str]] = {"leaf": "side"}

    side: Literal["left", "right"] = key(doc="where its hinge is")


class House(Record):
    """A house."""

    noun = "a house"
    one_of: ClassVar[tuple[str, ...]] = ("tent", "door")

    name: str = key("", doc="as a label")
    floors: int = key(1, ge=1, le=9, doc="how many")
    lamps: tuple[Lamp, ...] = key((), min_items=1, doc="in it")
    rooms: Mapping[str, tuple[int, ...]] | None = key(None, ge=0, doc="by name")
    tent: bool | None = key(None, doc="one has no door")
    door: Door | None = key(None, doc="its only one")
    note: Value | None = key(None, doc="anything")
    walls: str | tuple[str, ...] = key((), doc="what they are of")


HOUSE = FileFormat("house", House, title="Houses", doc="A house is a file.")


def read(text: str) -> House:
    house, problems = HOUSE.parse(text.encode(), "house.yaml")
    assert not problems, problems
    assert house is not None
    return house


def problems_of(text: str) -> list[str]:
    try:
        _, problems = HOUSE.parse(text.encode(), "f")
    except UserError as error:
        problems = error.problems
    return [str(problem) for problem in UserError(problems).problems]


def is_valid(text: str) -> bool:
    import yaml

    return bool(jsonschema.Draft202012Validator(HOUSE.schema()).is_valid(yaml.safe_load(text)))


def test_values_are_typed_and_what_is_left_out_has_its_default() -> None:
    house = read("{door: {side: left}, lamps: [{at_m: [1, [2, 3]]}], rooms: {hall: [1, 2]}, note: [a, {b: 1}]}")
    assert (house.name, house.floors, house.tent, house.walls) == ("", 1, None, ())
    assert house.door == Door(side="left")
    lamp = house.lamps[0]
    assert lamp.at_m == Spot(Range(1.0, 1.0, ("lamps", "0", "at_m", "x")), Range(2.0, 3.0, ("lamps", "0", "at_m", "y")))
    assert lamp.power_w == Range(40.0, 40.0)
    assert house.rooms == {"hall": (1, 2)}
    assert house.note is not None
    assert house.note.plain() == ["a", {"b": 1}]


def test_every_part_has_its_place() -> None:
    house = read("tent: true\nlamps:\n  - {at_m: [1, 2]}\n")
    assert house.place() == Place("house.yaml", 1, 1)
    assert house.place("lamps", "0", "at_m", "y") == Place("house.yaml", 3, 16)
    assert house.lamps[0].place("at_m") == Place("house.yaml", 3, 12)
    assert house.lamps[0].place("power_w") == house.lamps[0].place(), "not given: that of what it would be in"
    assert house.key_place("lamps") == Place("house.yaml", 2, 1)
    assert house.written.has("lamps", "0")
    assert not house.written.has("lamps", "1")


def test_one_or_a_list_may_be_written() -> None:
    assert read("{tent: true, walls: brick}").walls == "brick"
    assert read("{tent: true, walls: [brick, clay]}").walls == ("brick", "clay")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("5", ["f:1:1: a house must be a mapping, not the number 5\n  its keys are " + ", ".join(keys_of(House))]),
        ("{tent: true, floor: 2}", ["f:1:14: a house has no key 'floor'\n  did you mean 'floors'?"]),
        ("{door: {leaf: left}}", ["f:1:9: a door has no key 'leaf'\n  did you mean 'side'? It was renamed"]),
        ("{}", ["f:1:1: a house needs one of tent, door"]),
        ("{tent: true, door: {side: left}}", ["f:1:14: a house has 'tent' and 'door'\n  keep one of them"]),
        ("{tent: true, lamps: []}", ["f:1:21: 'lamps' is an empty list"]),
        (
            "{tent: true, lamps: [5]}",
            ["f:1:22: 'lamps[0]' must be a mapping, not the number 5\n  its keys are at_m, power_w"],
        ),
        ("{tent: true, lamps: [{}]}", ["f:1:22: a lamp needs 'at_m': where it is\n  write at_m: [x, y]"]),
        ("{tent: true, floors: 0}", ["f:1:22: 'floors' is 0, but must be >= 1 and <= 9"]),
        ("{tent: true, rooms: {hall: [1, -2]}}", ["f:1:32: 'rooms.hall[1]' is -2, but must be >= 0"]),
        (
            "{tent: true, lamps: [{at_m: [1, 2], power_w: [90, 20]}]}",
            ["f:1:46: the range of 'power_w' begins with its larger end\n  write [20, 90]"],
        ),
        (
            "{tent: true, lamps: [{at_m: [1, 2], power_w: [1, 2, 3]}]}",
            ["f:1:46: 'power_w' must be a number or a range [low, high], not a list of 3"],
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_place_and_what_to_do(text: str, said: list[str]) -> None:
    assert problems_of(text) == said
    assert not is_valid(text) or "larger end" in said[0], "a schema cannot compare the ends of a range"


def test_everything_that_is_wrong_is_said_at_once() -> None:
    text = "{tent: 1, floors: two, lamps: [{at_m: 3}, {at_m: [1, b], power_w: 0}], rooms: [], walls: [a, 2]}"
    assert [line.partition(": ")[0] for line in problems_of(text)] == [
        f"f:1:{column}" for column in (8, 19, 39, 54, 67, 79, 94)
    ]


def test_what_can_be_used_is_read_beside_what_is_wrong() -> None:
    house, problems = HOUSE.parse(b"{tent: true, floors: 77, lamps: [{at_m: [1, 2]}, {at_m: []}]}", "f")
    assert len(problems) == 2
    assert house is not None
    assert (house.floors, len(house.lamps)) == (1, 1)


@pytest.mark.parametrize(
    "data", [b"\xff", b"[" * 30, b"a: &a [*a]", b"a: 1\n---\n", b"a: !b 1", b"{a: 1, a: 2}", b"\0"]
)
def test_what_is_not_plain_yaml_is_refused_at_its_place(data: bytes) -> None:
    try:
        house, problems = HOUSE.parse(data, "f")
        assert house is None
    except UserError as error:
        problems = error.problems
    assert [problem.place.file for problem in problems if problem.place] == ["f"]


def test_a_field_that_is_not_declared_is_a_mistake_of_the_plugin() -> None:
    class Bare(Record):
        name: str = "x"

    with pytest.raises(DeclarationError, match=r"'name' of .*Bare is not a key"):
        keys_of(Bare)


_SCALARS = st.none() | st.booleans() | st.integers(-3, 120) | st.sampled_from(["a", "left", "2"])
_VALUES = st.recursive(
    _SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from([*keys_of(House), *keys_of(Lamp), "side"]), inner, max_size=3)
    ),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from([*keys_of(House), "oops"]), _VALUES))
def test_what_is_read_without_problems_is_valid_by_the_schema(data: dict[str, Any]) -> None:
    import json

    text = json.dumps(data)
    house, problems = HOUSE.parse(text.encode(), "f")
    valid = is_valid(text)
    assert valid or problems, "the schema may refuse nothing that can be used"
    if house is not None and not problems:
        assert valid
    if problems and valid:
        assert all("larger end" in problem.what for problem in problems), "all else a schema can refuse"


def test_the_page_has_every_key() -> None:
    page = HOUSE.reference()
    for cls in (House, Lamp, Door):
        assert all(f"| `{name}` |" in page for name in keys_of(cls))
    assert page.startswith("# Houses\n\nA house is a file.\n")
    assert "a number or a range, > 0 and <= 100 |" in page
