"""Pages and Markdown show hidden characters as escapes, and names as text."""

from __future__ import annotations

from pathlib import Path

import pytest

import graphnav
from graphnav.core.api.logs.log_channel import log_html
from graphnav.core.errors import printable
from graphnav.studies.ablation.report import document

HOSTILE = ["\x1b]0;title\x07", "\u202eright", "no\u200bwidth", "soft\u00adhyphen", "<script>alert(1)</script>"]


@pytest.mark.parametrize("name", HOSTILE)
def test_pages_show_text(name: str) -> None:
    page = log_html(Path(name), [], [name])
    assert printable(page) == page
    assert "<script>" not in page


def test_markdown_shows_text() -> None:
    assert document(HOSTILE[:3]) == "\\x1b]0;title\\x07\n\n\\u202eright\n\nno\\u200bwidth\n"


def test_drawings_show_text(tmp_path: Path) -> None:
    graph = tmp_path / "g\u202e.yaml"
    graph.write_text(
        r"""
about: "\u202eright \u200b"
inputs: {camera.image: {channel: "[red]CAMERA", type: graphnav_lcm.image_t}}
stages: {flow: {use: flow.lucas_kanade, in: {image: camera.image}}}
outputs: {flow.flow: {channel: "[/]FLOW"}}
""",
        encoding="utf-8",
    )
    drawing = graphnav.draw(graph)
    for text in (drawing.text, drawing.svg, drawing.mermaid, drawing.dot):
        assert printable(text) == text
    assert "[red]CAMERA" in drawing.text
    assert "u202eright" in drawing.svg
