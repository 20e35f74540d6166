"""Runs in a notebook: pictures and metrics, with strings of stages escaped."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest

import graphnav

RunToy = Callable[..., graphnav.Run]

PLUGIN = '''
from pathlib import Path
from graphnav import Source, Stage, Twist, hookimpl

FAMILY = "drawn"


class Still(Source):
    """Stands still."""

    def step(self) -> Twist:
        return Twist(v_mps=0.0, omega_radps=0.0)


@hookimpl
def graphnav_stages():
    return [Still]


@hookimpl
def graphnav_draw(recording, folder, video):
    {draws}
'''
PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
)


class Tags(HTMLParser):
    """Collects tags; the text of elements is of no interest."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)
        if tag != "img":
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def tags(html: str) -> set[str]:
    """Return the tags of HTML in which all are closed."""
    parser = Tags()
    parser.feed(html)
    assert parser.open == []
    return parser.seen


@pytest.fixture
def drawn(tmp_path: Path) -> Callable[[str], graphnav.Run]:
    """Return what runs a graph whose plugin draws so."""

    def run(draws: str) -> graphnav.Run:
        (tmp_path / "drawn.py").write_text(PLUGIN.replace("{draws}", draws))
        (tmp_path / "graph.yaml").write_text("run: {until_s: 0.5}\nstages: {c: {use: drawn.still}}\n")
        return graphnav.run(tmp_path / "graph.yaml", plugins=[tmp_path / "drawn.py"])

    return run


def test_the_pictures_are_inline(drawn: Callable[[str], graphnav.Run]) -> None:
    run = drawn(f"(folder / 'panels.png').write_bytes({PNG!r}); return [folder / 'panels.png']")
    assert run.folder / "panels.png" in run.pictures
    html = run._repr_html_()
    assert "img" in tags(html)
    shown = [base64.b64decode(data) for data in re.findall(r"data:image/png;base64,([^\"]*)", html)]
    assert PNG in shown
    (run.folder / "panels.png").unlink()
    assert "panels" not in run._repr_html_()


def test_what_cannot_be_drawn_is_told_and_costs_nothing_else(
    drawn: Callable[[str], graphnav.Run], caplog: pytest.LogCaptureFixture
) -> None:
    run = drawn(f"(folder / 'half.png').write_bytes({PNG!r}); raise ValueError('no\\nink')")
    assert run.outcome == "timeout"
    assert caplog.messages == ["not drawn: ValueError: no ink (ValueError at drawn.py:22 in graphnav_draw)"]
    assert [path.name for path in run.pictures] == ["half.png"]


def test_metrics_and_failures_are_text(run_toy: RunToy) -> None:
    html = run_toy(set={"sensor.grief": "raise"})._repr_html_()
    assert tags(html) == {"div", "p", "b", "pre", "table", "tr", "th", "td"}
    assert "worn &lt;b&gt;out&lt;/b&gt;" in html
    assert "way_m" in html


def test_a_log_shows_its_channels(run_toy: RunToy) -> None:
    html = run_toy().log._repr_html_()
    assert tags(html) == {"p", "table", "tr", "th", "td"}
    assert ">sensor.flow</td>" in html
    assert ">graphnav_lcm.flow_t</td><td>11</td><td>10</td>" in html
