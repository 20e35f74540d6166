"""Parameters convert values of graphs, and errors name the expected type."""

from pathlib import Path
from typing import Any, Literal

import pytest

from graphnav import ParamError
from graphnav.core.stage import Param


def declared(kind: Any, **bounds: Any) -> Param:
    return Param("x", kind, None, "doc", **bounds)


@pytest.mark.parametrize(
    ("kind", "given", "value"),
    [
        (float, 3, 3.0),
        (int, 3, 3),
        (bool, False, False),
        (str, "a", "a"),
        (Path, "a/b", Path("a/b")),
        (Path | None, None, None),
        (Path, 0, Path("0")),
        (Literal["mad", 2], 2, 2),
        (tuple[int, ...], [1, 2, 3], (1, 2, 3)),
        (tuple[float, str], [1, "a"], (1.0, "a")),
        (tuple[tuple[float, float], ...], [[0, 1], [2, 3]], ((0.0, 1.0), (2.0, 3.0))),
        (float | Literal["auto"], "auto", "auto"),
        (float | Literal["auto"], 2, 2.0),
        (Path | str, "rtsp://camera/1", "rtsp://camera/1"),
        (Path | str, "a.mp4", Path("a.mp4")),
    ],
)
def test_what_is_given_becomes_the_declared_type(kind: Any, given: Any, value: Any) -> None:
    parsed = declared(kind).parse(given)
    assert parsed == value
    assert type(parsed) is type(value)


@pytest.mark.parametrize(
    ("kind", "given", "said"),
    [
        (int, 2.0, "'x' must be an integer, not 2.0"),
        (int, True, "'x' must be an integer, not true"),
        (float, True, "'x' must be a number, not true"),
        (float, "1", "'x' must be a number, not the string '1'\n  remove the quotes"),
        (float, float("nan"), "'x' is nan, but must be finite"),
        (float, 10**400, "'x' is too large a number"),
        (float, -1e13, "'x' is too large a number"),
        (float, 1e-300, "'x' is too near to 0\n  write 0, or a number from 1e-12"),
        (bool, "yes", "'x' must be true or false, not the string 'yes'\n  write true"),
        (bool, 0, "'x' must be true or false, not 0"),
        (str, None, "'x' must be a string, not null"),
        (Path, "", "'x' must be a path, not the string ''"),
        (Path, -1, "'x' must be a path, not -1"),
        (Literal["mad", "otsu"], 3, "'x' must be \"mad\" or \"otsu\", not 3"),
        (tuple[float, float], [1], "'x' must be [a number, a number], not a list of 1"),
        (tuple[int, ...], {"a": 1}, "'x' must be a list, each an integer, not a mapping"),
        (float | None, "lots", "'x' must be a number or null, not the string 'lots'"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told(kind: Any, given: Any, said: str) -> None:
    with pytest.raises(ParamError) as caught:
        declared(kind).parse(given)
    assert str(caught.value).removeprefix("x: ") == said


def test_the_nearest_choice_is_proposed() -> None:
    with pytest.raises(ParamError, match=r"did you mean 'otsu'\?"):
        declared(Literal["mad", "otsu"]).parse("ostu")


@pytest.mark.parametrize(("number", "fits"), [(0, False), (0.1, True), (1, True), (1.1, False)])
def test_bounds_hold_for_every_number(number: float, *, fits: bool) -> None:
    for kind, given in ((float, number), (float | None, number), (tuple[float, ...], [0.5, number])):
        param = declared(kind, gt=0.0, le=1.0)
        if fits:
            param.parse(given)
        else:
            with pytest.raises(ParamError, match="but must be > 0 and <= 1"):
                param.parse(given)
