"""Strings of the network are shown as text, on one line."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from graphnav.core.errors import shown_name


@given(st.text())
@example("\u034f")
def test_nothing_is_left_that_a_terminal_obeys(text: str) -> None:
    shown = shown_name(text)
    assert shown.isprintable()
    assert shown == text or not (text.isascii() and text.isprintable())


def test_control_characters_stand_as_escapes() -> None:
    assert shown_name("a\x1b[31mred\n[bold]\x9b") == r"a\x1b[31mred\n[bold]\x9b"
