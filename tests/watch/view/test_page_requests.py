"""A browser may send anything; what is not an order is refused."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.watch.view.content.details import Cursor
from graphnav.watch.view.web.page_requests import LogCommand, RequestError, Shown, View, parse_request

JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)
KEYS = ("kind", "channel", "map", "run", "cursor", "number", "action", "value")
KINDS = st.sampled_from(["view", "shown", "log"])


def test_orders() -> None:
    view = {"kind": "view", "channel": "flow.flow", "map": True, "run": None, "cursor": [0.25, 0.5]}
    assert parse_request(json.dumps(view)) == View("flow.flow", with_map=True, cursor=Cursor(0.25, 0.5))
    assert parse_request('{"kind": "shown", "number": 3}') == Shown(3)
    assert parse_request('{"kind": "log", "action": "seek", "value": 1.5}') == LogCommand("seek", 1.5)
    assert parse_request('{"kind": "view", "cursor": [1, 0]}') == View(), "beside the picture"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1]",
        "{}",
        "[" * 4000,
        b"\xff\xff",
        '{"kind": "log", "action": "rm"}',
        '{"kind": "shown", "number": 1e999}',
        '{"kind": "shown", "number": true}',
        '{"kind": "view", "channel": 7}',
        '{"kind": "view", "cursor": ["a", "b"]}',
    ],
)
def test_anything_else_is_refused(text: str | bytes) -> None:
    with pytest.raises(RequestError):
        parse_request(text)


@given(st.dictionaries(st.sampled_from(KEYS), JSON), KINDS | JSON)
def test_every_json_is_an_order_or_refused(order: dict[str, Any], kind: Any) -> None:
    with suppress(RequestError):
        parse_request(json.dumps({**order, "kind": kind}))


@given(st.text() | st.binary())
def test_every_text_is_an_order_or_refused(text: str | bytes) -> None:
    with suppress(RequestError):
        parse_request(text)
