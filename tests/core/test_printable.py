"""Text that acts on a terminal, reorders or is invisible is shown as escapes; ordinary text stays."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.core.errors import printable

JOINER = "\u200d"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b]0;title\x07", r"\x1b]0;title\x07"),
        ("\x1b[31m\x9b31m\x7f\x00\r\b", r"\x1b[31m\x9b31m\x7f\x00\r\x08"),
        ("\u202aa\u202eb\u202c", r"\u202aa\u202eb\u202c"),
        ("\u2066a\u2069\u200e\u200f\u061c", r"\u2066a\u2069\u200e\u200f\u061c"),
        ("a\u200bb\u200cc\u2060d\ufeff", r"a\u200bb\u200cc\u2060d\ufeff"),
        ("a\u200db", r"a\u200db"),
        ("a\u034fb\u3164\U000e0041\u115f", r"a\u034fb\u3164\U000e0041\u115f"),
        ("soft\u00adhyphen", r"soft\xadhyphen"),
        ("a\u2028b\u2029c", r"a\u2028b\u2029c"),
        ("\udc80", r"\udc80"),
    ],
)
def test_hidden_characters_are_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown


@pytest.mark.parametrize(
    "text",
    [
        "two lines\nand a\ttab",
        "10\u00a0m, 1\u202f000, \u3000日本語",
        "Größe, naïve, Ελλάς, שלום, مرحبا",
        "👩\u200d💻 🏳\ufe0f\u200d🌈 👍🏽 ❤\ufe0f 👩🏽\u200d🚀",
        "│ ─ ⣿ ▁▂▃ ✓",
    ],
)
def test_ordinary_text_stays(text: str) -> None:
    assert printable(text) == text


@given(st.text())
def test_nothing_hidden_is_left(text: str) -> None:
    shown = printable(text)
    assert printable(shown) == shown
    left = {unicodedata.category(char) for char in shown if char not in ("\n", "\t", JOINER)}
    assert not left & {"Cc", "Cf", "Cs", "Zl", "Zp"}
