"""Two variants as a command names them."""

from __future__ import annotations

import pytest

from graphnav.core.errors import UserError
from graphnav.studies.ablation.results.compare_variants import parse_pairs

VARIANTS = ("plane.ica + planar.motion", "plane.affine", "gains=[1, 2]", "gains=[1, 3]")


@pytest.mark.parametrize(
    ("text", "pair"),
    [
        ("plane.affine,plane.ica + planar.motion", ("plane.affine", "plane.ica + planar.motion")),
        (" plane.affine ,  gains=[1, 2]", ("plane.affine", "gains=[1, 2]")),
        ("gains=[1, 3],gains=[1, 2]", ("gains=[1, 3]", "gains=[1, 2]")),
    ],
)
def test_a_pair_is_split_where_both_sides_are_variants(text: str, pair: tuple[str, str]) -> None:
    assert parse_pairs([text], VARIANTS) == (pair,)


def test_all_that_is_wrong_is_told() -> None:
    with pytest.raises(UserError) as caught:
        parse_pairs(["plane.affine", "plane.affine,plane.afine", "plane.affine,plane.affine"], VARIANTS)
    known = "variants of this study are plane.ica + planar.motion; plane.affine; gains=[1, 2]; gains=[1, 3]"
    assert str(caught.value) == (
        f"contrast 'plane.affine' names one variant\n  write two, A,B; {known}\n"
        "contrast 'plane.affine,plane.afine': the study has no variant 'plane.afine'\n"
        "  did you mean 'plane.affine'?\n"
        f"contrast 'plane.affine,plane.affine' names the same variant twice\n  name two; {known}"
    )
