"""Seeds: a range without its end, or a list, each world once."""

import pytest

from graphnav.core.errors import Place, UserError
from graphnav.studies.ablation.study.worlds import MAX_SEEDS, parse_seeds


@pytest.mark.parametrize(
    ("text", "seeds"),
    [
        ("0:3", (0, 1, 2)),
        (" 1000 : 1002 ", (1000, 1001)),
        ("7:8", (7,)),
        ("[7]", (7,)),
        ("[1, 5, 7]", (1, 5, 7)),
        ("5,1", (5, 1)),
        ("4294967295,0", (4_294_967_295, 0)),
    ],
)
def test_what_seeds_mean(text: str, seeds: tuple[int, ...]) -> None:
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("5:5", "the end is not included"),
        ("9:2", "ends before it begins\n  write 2:9"),
        ("-3:2", "is not a range or a list of seeds"),
        ("1:", "is not a range or a list of seeds"),
        ("1:2:3", "is not a range or a list of seeds"),
        ("a:b", "is not a range or a list of seeds"),
        ("", "is not a range or a list of seeds"),
        ("[]", "is not a range or a list of seeds"),
        ("[1", "is not a range or a list of seeds"),
        ("1,", "is not a range or a list of seeds"),
        ("1.5", "is not a range or a list of seeds"),
        ("²:³", "is not a range or a list of seeds"),
        ("50", "0:50 for 50 worlds"),
        ("1,2,1", "duplicate seed 1"),
        ("4294967296,1", "must be from 0 to 4294967295"),
        ("4294967290:4294967299", "must be from 0 to 4294967295"),
        ("0:999999999999", "at most 100000"),
        (f"0:{10**400}", "is not a range or a list of seeds"),
    ],
)
def test_what_seeds_cannot_be(text: str, said: str) -> None:
    with pytest.raises(UserError) as caught:
        parse_seeds(text, Place("--seeds"))
    assert str(caught.value).startswith("--seeds: ")
    assert said in str(caught.value)


def test_as_many_as_are_allowed() -> None:
    assert len(parse_seeds(f"0:{MAX_SEEDS}")) == MAX_SEEDS
