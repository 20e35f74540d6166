"""Channels are chosen by globs and regular expressions."""

from __future__ import annotations

import pytest

from graphnav.core.errors import UserError
from graphnav.core.record import ChannelFilter

NAMES = ["robot.image", "robot.state", "robotXimage", "CAMERA", "flow.flow", "a\nb"]


@pytest.mark.parametrize(
    ("globs", "regexes", "taken"),
    [
        ([], [], NAMES),
        (["robot.*"], [], ["robot.image", "robot.state"]),
        (["*image", "CAMERA"], [], ["robot.image", "robotXimage", "CAMERA"]),
        ([], ["robot.image"], ["robot.image", "robotXimage"]),
        ([], ["robot"], []),
        (["flow.*"], ["[A-Z]+"], ["CAMERA", "flow.flow"]),
        (["[!r]*"], [], ["CAMERA", "flow.flow", "a\nb"]),
    ],
)
def test_what_matches_is_taken_and_what_does_not_if_inverted(
    globs: list[str], regexes: list[str], taken: list[str]
) -> None:
    assert [name for name in NAMES if ChannelFilter(globs, regexes).takes(name)] == taken
    if globs or regexes:
        inverted = ChannelFilter(globs, regexes, invert=True)
        assert [name for name in NAMES if inverted.takes(name)] == [name for name in NAMES if name not in taken]


def test_what_is_not_a_regular_expression_is_said() -> None:
    with pytest.raises(UserError) as caught:
        ChannelFilter(regexes=["robot("])
    assert str(caught.value) == (
        "--regex: 'robot(' is not a regular expression: missing ), unterminated subpattern at position 5\n"
        "  escape special characters with a backslash"
    )
