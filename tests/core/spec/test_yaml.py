"""Reading keeps every place and refuses what would explode."""

import pytest

from graphnav.core.errors import Place, UserError
from graphnav.core.spec import MAX_BYTES, Value, parse_yaml


def read(text: str) -> Value:
    value, problems = parse_yaml(text.encode(), "f.yaml")
    assert not problems
    return value


def test_every_value_and_key_has_its_place() -> None:
    value = read("a:\n  b: [1, two]\n").data
    assert isinstance(value, dict)
    inner = value["a"].value.data
    assert isinstance(inner, dict)
    assert inner["b"].place == Place("f.yaml", 2, 3)
    items = inner["b"].value.data
    assert isinstance(items, list)
    assert [item.place for item in items] == [Place("f.yaml", 2, 7), Place("f.yaml", 2, 10)]


def test_a_byte_order_mark_does_not_matter() -> None:
    value, _ = parse_yaml(b"\xef\xbb\xbfa: 1", "f.yaml")
    assert value.plain() == {"a": 1}


def test_lines_may_end_as_on_windows() -> None:
    assert read("a: 1\r\nb: 2\r\n").plain() == {"a": 1, "b": 2}


def test_an_alias_stands_for_what_its_anchor_says() -> None:
    assert read("a: &x [1]\nb: *x\n").plain() == {"a": [1], "b": [1]}


def test_a_merge_key_is_a_key_like_any_other() -> None:
    assert read("a: &x {p: 1}\nb: {<<: *x}\n").plain()["b"] == {"<<": {"p": 1}}


def test_quoted_words_are_texts() -> None:
    assert read("a: ['1', \"true\", 'null']").plain() == {"a": ["1", "true", "null"]}


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        "{a: " * 50_000,
        "- " * 100_000,
        "a: &a [*a, *a]",
        "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9) if i else 'x'}]\n" for i in range(40)),
        "x" * (MAX_BYTES + 1),
    ],
    ids=["lists", "mappings", "dashes", "itself", "laughs", "size"],
)
def test_what_would_explode_is_refused(text: str) -> None:
    with pytest.raises(UserError):
        parse_yaml(text.encode(), "f.yaml")
