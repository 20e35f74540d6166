"""The page in a browser: what it shows, what it does on a click or a key, what it never does."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from graphnav import About
from graphnav.core.record import LogWriter

from .browser import CHROMIUM, Browser
from .drive import MARKUP, messages
from .served import Served

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: apt-get install chromium")

EYES_HOST = "jetson: 0.4 ms away, clock 12.3 ms ahead ± 0.2 ms, set 1 time"
SCRIPT = """
window.id = (id) => document.getElementById(id);
window.all = (selector) => [...document.querySelectorAll(selector)];
window.strings = (selector) => all(selector).map((node) => node.textContent);
window.edge = (ref) => document.querySelector(`.edge[aria-label^="${ref}:"]`);
window.place = (node) => (({x, y, width, height}) => [x, y, width, height])(node.getBoundingClientRect());
window.slide = (s) => {
  id("time").value = s;
  id("time").dispatchEvent(new Event("input"));
  id("time").dispatchEvent(new Event("change"));
};
const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const luminance = (rgb) => {
  const [r, g, b] = rgb.match(/[\\d.]+/g).slice(0, 3).map((c) => linear(c / 255));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
window.contrast = (selector) => {
  const panel = luminance(getComputedStyle(id("map-panel")).backgroundColor);
  const ink = luminance(getComputedStyle(document.querySelector(selector)).color);
  return (Math.max(ink, panel) + 0.05) / (Math.min(ink, panel) + 0.05);
};
"""
"""JavaScript helpers of the tests."""

Serve = Callable[[Path | str], Served]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """Return a browser for the tests of this file."""
    with Browser(tmp_path_factory.mktemp("chromium"), SCRIPT) as browser:
        yield browser


@pytest.fixture
def page(browser: Browser, serve: Serve, log: Path) -> Browser:
    """Return a browser at the page of a log, paused at its end."""
    return opened(browser, serve(log))


@pytest.fixture
def page_of_processes(browser: Browser, serve: Serve, log_of_processes: Path) -> Browser:
    """Return a browser at the page of the log of a run over processes, paused at its end."""
    return opened(browser, serve(log_of_processes))


def opened(browser: Browser, served: Served) -> Browser:
    """Open the page of a log, paused at its end; return the browser."""
    assert served.source.log is not None
    with served.source.lock:
        served.source.log.pause()
        served.source.log.seek(3.9)
    browser.open("about:blank")  # else the page of the test before, whose server is gone, asks for it again
    browser.wait_for("location.href === 'about:blank'")
    browser.requests.clear()
    browser.complaints.clear()
    browser.open(served.url)
    browser.wait_for("all('.graph .stage').length === 11 && all('#fields tr').length > 0")
    return browser


def text(page: Browser, selector: str) -> str:
    found = page.evaluate(f"document.querySelector({json.dumps(selector)}).textContent")
    assert isinstance(found, str)
    return found


@pytest.mark.parametrize("number", [1_795_000_000_123_456, -(2**53) + 1, 0])
def test_integers_show_all_digits(page: Browser, number: int) -> None:
    assert page.evaluate(f"import('/format.js').then((format) => format.number({number}))") == str(number)


def test_it_shows_graph_channels_map_and_a_picture(page: Browser) -> None:
    assert text(page, "#graph-title").startswith("Follow the free floor")
    assert page.evaluate("edge('flow.flow').getAttribute('aria-label')") == "flow.flow: 10.0 Hz, 0 lost"
    assert page.evaluate("edge('steer.steering').getAttribute('aria-label')").endswith(", 7 lost")
    assert "4 overtaken" in page.evaluate("strings('.graph text.lost')")
    assert "4.5 ms" in page.evaluate("strings('.graph .time')")
    assert text(page, "#details-title") == "robot.image", "a camera is opened first"
    assert page.wait_for("id('picture').width") > 100
    page.wait_for("all('.floor .wall').length === 2")
    assert page.wait_for("all('.floor .path')[0].getAttribute('points').split(' ').length") >= 40
    assert text(page, "#map-readout").startswith("robot 3.90, ")


def test_it_asks_for_nothing_elsewhere_and_complains_about_nothing(page: Browser) -> None:
    origin = page.evaluate("location.host")
    assert page.requests
    assert {request.split("/")[2] for request in page.requests} == {origin}
    assert page.complaints == []


def test_names_and_texts_are_never_markup(page: Browser) -> None:
    page.evaluate(f"all('#channels button').find((button) => button.textContent === {MARKUP!r}).click()")
    page.wait_for("id('fields').textContent.includes('alert(2)')")
    assert text(page, "#details-title") == MARKUP
    assert page.evaluate("all('img, main script').length") == 0
    assert page.complaints == []


def test_processes_and_the_ways_of_edges_are_shown(page_of_processes: Browser) -> None:
    page = page_of_processes
    page.wait_for("!id('processes-panel').hidden && all('#edges tbody tr').length === 3")
    rows = "all('{} tbody tr').map((row) => [...row.children].map((cell) => cell.textContent))"
    assert page.evaluate(rows.format("#processes")) == [
        ["(run)", "robot, planar, control, drive", "4242", "ready", "0", "25 %", "62 MB", ""],
        ["eyes", "flow, plane", "4242", "ready", "0", "25 %", "62 MB", EYES_HOST],
        [MARKUP, "steer", "–", "restarting", "2", "25 %", "62 MB", ""],
    ]
    assert page.evaluate(rows.format("#edges")) == [
        ["plane.flow", "flow.flow", "within eyes", "4"],
        ["flow.image", "robot.image", "(run) → eyes", "0"],
        ["steer.plane", "plane.plane", f"eyes → {MARKUP}", "0"],
    ]
    host = "getComputedStyle(document.querySelector('#processes td:last-child')).display"
    assert page.evaluate(host) == "table-cell"
    page.evaluate("id('processes-panel').classList.add('no-hosts')")
    assert page.evaluate(host) == "none"
    assert page.evaluate("strings('#processes td.bad')") == [EYES_HOST, "restarting", "2"]
    labels = page.evaluate("strings('.graph text.lost').filter((text) => /from|overtaken/.test(text)).sort()")
    assert labels == ["4 overtaken", "from (run)", "from eyes"]
    titles = page.evaluate("strings('.graph .stage title')")
    assert any(title.endswith("in process eyes, ready") for title in titles)
    assert page.evaluate("all('img, main script').length") == 0
    assert page.complaints == []
    for width in (390, 1280):
        page.resize(width, 900)
        page.evaluate("new Promise((done) => requestAnimationFrame(done))")
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_run_in_one_process_shows_none(page: Browser) -> None:
    assert page.evaluate("getComputedStyle(id('processes-panel')).display") == "none"


def test_a_click_on_an_edge_opens_it_with_its_plot(page: Browser) -> None:
    page.evaluate("edge('control.twist').dispatchEvent(new MouseEvent('click'))")
    page.wait_for("!id('plot-box').hidden && strings('#legend span:nth-child(2)').join() === 'v_mps,omega_radps'")
    newest = text(page, "#legend li:nth-child(2) output")
    page.evaluate("id('plot').scrollIntoView({block: 'center'})")
    x, y, width, height = page.evaluate("place(id('plot'))")
    page.move(x + 0.95 * width, y + 0.5 * height)
    page.wait_for(f"strings('#legend output')[1] !== {newest!r}")


def test_keys_open_a_channel_and_read_a_picture(page: Browser) -> None:
    page.evaluate("edge('flow.flow').focus()")
    page.press("Enter")
    page.wait_for("id('details-title').textContent === 'flow.flow'")
    page.wait_for("!id('picture-box').hidden")
    page.evaluate("id('picture').focus()")
    page.press("ArrowRight")
    page.wait_for("/x 8, y 6 px.*uv_px .*valid 1/.test(id('readout').textContent)")


def test_the_log_is_moved_by_slider_button_and_keys(page: Browser) -> None:
    page.evaluate("slide(1)")
    page.wait_for("id('at').textContent.startsWith('1.00 ')")
    page.wait_for("id('readout').textContent !== ''")
    page.evaluate("id('step-on').click()")
    page.wait_for("id('at').textContent.startsWith('1.10 ')")
    page.evaluate("document.activeElement.blur()")
    page.press(",")
    page.wait_for("id('at').textContent.startsWith('1.00 ')")
    page.press(" ")
    page.wait_for("id('at').textContent.startsWith('3.90 ')")
    page.wait_for("id('play').getAttribute('aria-label') === 'play'")


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("dark", [False, True])
def test_it_fits_the_window_and_can_be_read(page: Browser, width: int, dark: bool) -> None:
    page.resize(width, 900, dark=dark)
    page.evaluate("new Promise((done) => requestAnimationFrame(done))")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for selector in ("#details-title", "#details-type", "#readout", "#channels thead th", "#channels .bad", "#link"):
        assert page.evaluate(f"contrast({selector!r})") >= 4.5, selector


def test_labels_and_wires_of_seven_outputs_do_not_cross(page: Browser) -> None:
    page.resize(1280, 900)
    labels = "all('.edge').flatMap((one) => [one.querySelector('.rate'), one.querySelector('.lost')])"
    assert page.evaluate("""all('.edge[aria-label^="robot."]').length""") == 7
    crossings = page.evaluate(f"""(() => {{
      const boxes = {labels}.filter((node) => node.textContent).map((node) => node.getBBox());
      const hits = boxes.filter((a) => boxes.some((b) => a !== b && a.x < b.x + b.width && b.x < a.x + a.width
        && a.y + 3 < b.y + b.height && b.y + 3 < a.y + a.height));
      const heights = all('.graph .wires .wire:not(.stub)').flatMap((wire) => {{
        const start = wire.getPointAtLength(0);
        return [15, 30, 45, 60].map((u) => wire.getPointAtLength(u).y - start.y);
      }});
      return [hits.length, Math.max(...heights.map(Math.abs))];
    }})()""")
    assert crossings == [0, 0]


def test_targets_are_large_enough_for_fingers_on_a_phone(page: Browser) -> None:
    page.resize(390, 844)
    for selector in ("#timeline button", "#timeline select", "#time"):
        assert min(page.evaluate(f"all('{selector}').map((node) => node.getBoundingClientRect().height)")) >= 44
    for selector in (".edge rect", "#channels tbody tr"):
        assert min(page.evaluate(f"all('{selector}').map((node) => node.getBoundingClientRect().height)")) >= 30


def test_nothing_jumps_while_a_log_plays(page: Browser) -> None:
    page.evaluate("id('play').click()")
    page.wait_for("parseFloat(id('at').textContent) < 1")
    page.wait_for("parseFloat(id('at').textContent) > 0.3")
    before = page.evaluate("all('main > section').map(place)")
    page.wait_for("parseFloat(id('at').textContent) > 2.5")
    assert np.array(page.evaluate("all('main > section').map(place)")) == pytest.approx(np.array(before), abs=1)


def test_a_log_without_its_graph_says_so_once_it_was_read(browser: Browser, serve: Serve, tmp_path: Path) -> None:
    path = tmp_path / "foreign.lcmlog"
    with LogWriter(path) as writer:
        for channel, utime, data in messages():
            if channel != About.CHANNEL:
                writer.write(channel, utime, data)
    browser.open(serve(path).url)
    browser.wait_for("id('graph-empty')?.textContent === 'The log does not hold the graph that produced it.'")
    assert browser.evaluate("!id('graph-empty').hidden")
    browser.open("about:blank")


def test_a_lost_server_is_said(browser: Browser, serve: Serve, log: Path) -> None:
    served = serve(log)
    browser.open(served.url)
    browser.wait_for("id('link')?.dataset.state === 'open'")
    served.end()
    browser.wait_for("id('link').textContent.startsWith('no connection')")
    browser.open("about:blank")
