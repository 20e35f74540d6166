"""The flame graph: XML with every name escaped, widths in proportion, labels that fit."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import pytest

from graphnav.develop.profiling.flame import COLOURS, Node
from graphnav.develop.profiling.profile import Profile
from graphnav.develop.profiling.stopwatch import Part

from .conftest import ProfileText

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def profile(profile_text: ProfileText) -> Profile:
    return profile_text()[0]


def boxes_of(svg: str) -> list[tuple[float, float, str]]:
    """Return x, width and tooltip of every box."""
    found = ET.fromstring(svg).iter(f"{SVG}rect")
    return [
        (float(one.get("x", "")), float(one.get("width", "")), one.findtext(f"{SVG}title", ""))
        for one in found
        if one.get("class") == "box"
    ]


def test_names_are_escaped(profile: Profile) -> None:
    name = '</title><script>alert("1")</script>&\x1b'
    tree = Node(name, "tick", 1.0, name, (Node(name, "function", 1.0, name),))
    svg = replace(profile, graph=name, tree=tree).flame
    assert "<script>" not in svg
    assert "\x1b" not in svg
    assert all('</title><script>alert("1")</script>&' in tooltip for _, _, tooltip in boxes_of(svg))


def test_widths_are_in_proportion_and_within_the_box_above(profile: Profile) -> None:
    tree = Node(
        "tick", "tick", 8.0, "", (Node("a", "stage", 2.0), Node("b", "stage", 4.0, "", (Node("s", "step", 3.0),)))
    )
    boxes = boxes_of(replace(profile, tree=tree).flame)
    assert [(x, width) for x, width, _ in boxes] == [(0, 1200), (0, 300), (300, 600), (300, 450)]
    assert boxes[3][2] == "s: 3.000 ms of a tick, 37.5%"


def test_every_part_of_the_tick_has_a_box_and_a_colour(profile: Profile) -> None:
    svg = profile.flame
    tooltips = [tooltip for _, _, tooltip in boxes_of(svg)]
    assert len(tooltips) == sum(1 for _ in profile.tree.walk())
    assert {"plus", "step", "check", "encode plus.twist", "log plus.twist"} <= {t.partition(":")[0] for t in tooltips}
    assert {*map(str, Part), "function"} == set(COLOURS)


@pytest.mark.parametrize("n_stages", [1, 11, 300, 1000])
def test_labels_fit_their_boxes_however_many_stages_there_are(profile: Profile, n_stages: int) -> None:
    stages = tuple(Node(f"a_stage_with_a_long_name_{number}", "stage", 1.0) for number in range(n_stages))
    root = ET.fromstring(replace(profile, tree=Node("tick", "tick", 1.1 * n_stages, "", stages)).flame)
    width = float(root.get("width", ""))
    assert 1200 <= width <= 12_000
    labels = [one.text or "" for one in root.iter(f"{SVG}text") if re.match("a_", one.text or "")]
    assert all(len(label) * 6.6 <= width / 1.1 / n_stages for label in labels)
    assert bool(labels) == (n_stages < 1000)


def test_a_profile_without_time_is_still_a_picture(profile: Profile) -> None:
    assert len(boxes_of(replace(profile, tree=Node("tick", "tick", 0.0)).flame))
