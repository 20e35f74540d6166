"""Folders are called like what is in them, and no two alike on any file system."""

import re

import pytest

from graphnav.studies.ablation.plan.build_plan import folder_names

HARD = (
    "plane.ica + planar.motion",
    "75 deg",
    "75_deg",
    "75/deg",
    "75 DEG",
    "..",
    ".",
    "...",
    "Grad °",
    "µ",
    "ß",
    "日本",
    "-rf",
    "a" * 300,
    "a" * 301,
    "é" * 300,
    "steer.sigma_ratio=0.25",
    "lucas_kanade, 2 layers",
    "a\\b:c*d?e|f",
)


def test_what_is_plain_keeps_its_name() -> None:
    names = folder_names(["plane.ica", "plane.ica + steer.sigma_ratio=0.25", "75 deg", "0.3 m/s"])
    assert list(names.values()) == ["plane.ica", "plane.ica+steer.sigma_ratio=0.25", "75_deg", "0.3_m_s"]


def test_every_name_is_fit_for_every_file_system() -> None:
    names = folder_names(HARD)
    assert list(names) == list(HARD)
    assert len({name.casefold() for name in names.values()}) == len(HARD)
    for name in names.values():
        assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._+=-]*", name)
        assert len(name) <= 110


@pytest.mark.parametrize("text", HARD)
def test_a_name_does_not_depend_on_those_that_it_cannot_be_taken_for(text: str) -> None:
    assert folder_names([text])[text] == folder_names([text, "another", "a third"])[text]


def test_graphs_of_one_name_in_two_folders() -> None:
    names = folder_names(["a/corridor.yaml", "b/corridor.yaml", "pillars"], lambda text: text.split("/")[-1])
    assert names["pillars"] == "pillars"
    assert len(set(names.values())) == 3
    assert all(name.startswith("corridor.yaml-") for text, name in names.items() if "/" in text)
