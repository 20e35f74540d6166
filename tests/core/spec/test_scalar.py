"""Plain scalars mean what the core rules of YAML 1.2 say, and what is written reads back."""

import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.spec import parse_scalar, parse_yaml, write_value


@pytest.mark.parametrize("text", ["on", "off", "yes", "no", "y", "1:30", "2026-01-31", "0b11", "1_000", "<<", "=", "١"])
def test_traps_of_yaml_1_1_are_texts(text: str) -> None:
    assert parse_scalar(text) == text


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 0.001), ("1e5", 1e5), (".5", 0.5), ("5.", 5.0), ("-.inf", -math.inf), ("007", 7), ("0o17", 15)],
)
def test_numbers(text: str, value: float) -> None:
    parsed = parse_scalar(text)
    assert parsed == value
    assert type(parsed) is type(value)


@pytest.mark.parametrize("text", ["", "~", "null", "Null", "NULL"])
def test_nothing(text: str) -> None:
    assert parse_scalar(text) is None


@pytest.mark.parametrize(("text", "value"), [("true", True), ("False", False), ("TRUE", True), ("tRue", "tRue")])
def test_truth(text: str, value: object) -> None:
    assert parse_scalar(text) is value or parse_scalar(text) == value


def test_a_number_of_too_many_digits_is_infinite() -> None:
    assert parse_scalar("9" * 5000) == math.inf


SCALARS = st.none() | st.booleans() | st.integers(-(10**18), 10**18) | st.floats(allow_nan=False) | st.text(max_size=30)
VALUES = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=4), max_leaves=8)


@given(VALUES)
def test_what_is_written_reads_back(value: object) -> None:
    written = write_value(value)
    assert "\n" not in written
    read, problems = parse_yaml(f"key: {written}\n".encode("utf-8", "surrogatepass"), "f")
    assert not problems
    assert read.plain() == {"key": value}


@given(st.floats(allow_nan=False))
def test_numbers_that_are_written_are_numbers_for_yaml_1_1_too(number: float) -> None:
    assert yaml.safe_load(write_value(number)) == number
