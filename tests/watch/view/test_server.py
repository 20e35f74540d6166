"""The server gives its files to its own pages, its updates to pages of its own origin, and 404 to all else."""

from __future__ import annotations

import http.client
import json
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from graphnav.watch.view.web.server import page_files

from .drive import MARKUP
from .served import Page, Served

FORBIDDEN = ("http:", "https:", "innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "style=", "onclick=")

Serve = Callable[[Path | str], Served]


@pytest.fixture
def served(serve: Serve, log: Path) -> Served:
    """Return the page of a log, paused at its end."""
    return at_end(serve(log))


def at_end(served: Served) -> Served:
    """Pause the log of a page at its end; return the page."""
    assert served.source.log is not None
    with served.source.lock:
        served.source.log.pause()
        served.source.log.seek(3.9)
    return served


def get(served: Served, path: str, **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=20)
    connection.putrequest("GET", path, skip_host=True)
    for name, value in {"Host": f"127.0.0.1:{served.port}", **headers}.items():
        connection.putheader(name, value)
    connection.endheaders()
    return connection.getresponse()


@pytest.mark.parametrize("route", sorted(page_files()))
def test_every_file_is_served_with_its_type_and_closed_to_others(served: Served, route: str) -> None:
    response = get(served, route)
    body = response.read()
    assert response.status == 200
    assert body == page_files()[route].body
    assert "default-src 'self'" in response.headers["Content-Security-Policy"]
    assert "unsafe" not in response.headers["Content-Security-Policy"]
    assert response.headers["X-Content-Type-Options"] == "nosniff"
    assert response.headers["Content-Type"].partition(";")[0] in {
        "text/html",
        "text/css",
        "text/javascript",
        "image/svg+xml",
    }


def test_the_page_asks_for_nothing_elsewhere() -> None:
    for route, file in page_files().items():
        text = file.body.decode().replace("http://www.w3.org/2000/svg", "")
        assert [word for word in FORBIDDEN if word in text] == [], route


@pytest.mark.parametrize(
    "path",
    ["/index.html", "/nothing", "/../server.py", "/%2e%2e/server.py", "//", "/main.js?x=1", "/page/main.js", "/*"],
)
def test_all_else_is_not_found(served: Served, path: str) -> None:
    response = get(served, path)
    assert (response.status, response.read()) == (404, b"404 Not Found\n")


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", ""])
@pytest.mark.parametrize("path", ["/", "/updates", "/nothing"])
def test_a_wrong_host_is_refused(served: Served, path: str, host: str) -> None:
    assert get(served, path, Host=host).status == 403


def test_updates_are_no_file(served: Served) -> None:
    origin = served.url.rstrip("/")
    assert get(served, "/updates", Origin=origin).status == 426


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1", "http://localhost:1"])
def test_pages_of_other_origins_are_refused(served: Served, origin: str) -> None:
    with pytest.raises(InvalidStatus) as refused:
        Page(served, origin=origin)
    assert refused.value.response.status_code == 403


def test_other_methods_and_garbage_end_the_connection_and_nothing_else(served: Served) -> None:
    for garbage in (b"POST / HTTP/1.1\r\nHost: x\r\n\r\n", b"\x00\xff" * 500, b"GET " + b"/" * 100_000, b""):
        with socket.create_connection(("127.0.0.1", served.port), timeout=20) as raw:
            raw.sendall(garbage)
            raw.shutdown(socket.SHUT_WR)
            while raw.recv(65536):
                pass
    assert get(served, "/").status == 200


@pytest.mark.parametrize("order", ["", "[]", '{"kind": "view", "channel": 7}', "x" * 100_000])
def test_what_is_not_an_order_ends_the_connection(served: Served, order: str) -> None:
    with Page(served) as page:
        page.socket.send(order)
        with pytest.raises(ConnectionClosed):
            page.until(lambda _: False)
    with Page(served) as page:
        assert page.update()["state"]["channels"], "others go on"


def test_a_page_is_told_graph_channels_and_health(served: Served) -> None:
    with Page(served) as page:
        assert page.known["log"] is True
        assert page.known["length_s"] == pytest.approx(3.9)
        known = page.until(lambda known: "graph" in known)
        assert {box["name"] for box in known["graph"]["boxes"]} >= {
            "robot", "flow", "planar", "plane", "steer", "control", "drive"
        }  # fmt: skip
        image = page.channel("robot.image")
        assert (image["rate_hz"], image["lost"]) == (pytest.approx(10), 0)
        assert page.channel("steer.steering")["lost"] == 7
        stages = {stage["name"]: stage for stage in known["state"]["run"]["status"]["stages"]}
        assert stages["plane"]["p50_ms"] == 4.5
        assert "details" not in known, "nothing is decoded that is not shown"


def test_a_page_is_told_the_processes_and_the_ways_of_edges(serve: Serve, log_of_processes: Path) -> None:
    with Page(at_end(serve(log_of_processes))) as page:
        known = page.until(lambda known: (known["state"]["run"] or {}).get("status") is not None)
        status = known["state"]["run"]["status"]
    assert [(one["name"], one["state"], one["stages"]) for one in status["processes"]] == [
        ("", "ready", ["robot", "planar", "control", "drive"]),
        ("eyes", "ready", ["flow", "plane"]),
        (MARKUP, "restarting", ["steer"]),
    ]
    assert [edge["processes"] for edge in status["edges"]] == [["eyes", "eyes"], ["", "eyes"], ["eyes", MARKUP]]


def test_a_page_gets_the_channel_that_it_shows(served: Served) -> None:
    with Page(served) as page:
        page.say(kind="view", channel="flow.flow", cursor=[0.99, 0.5])
        details = page.until(lambda known: "details" in known)["details"]
        assert details["channel"] == "flow.flow"
        assert details["fields"]["uv_px"]["shape"] == [12, 16, 2]
        assert details["under_cursor"]["x_px"] == 15
        assert details["under_cursor"]["values"]["uv_px"] == [pytest.approx(7 / 8), 0.0]
        page.say(kind="view", channel="control.twist")
        details = page.until(lambda known: known["details"]["channel"] == "control.twist")["details"]
        assert details["series"] == ["v_mps", "omega_radps"]
        assert len(details["points"]) == 40, "the plot begins with what was received before"
        assert details["points"][-1][0] == pytest.approx(3.9)
        page.say(kind="view", channel="no.such")
        details = page.until(lambda known: known["details"]["channel"] == "no.such")["details"]
        assert details["missing"] == "not_received"


def test_a_page_gets_the_map_and_the_path(served: Served) -> None:
    with Page(served) as page:
        page.say(kind="view", map=True)
        known = page.until(lambda known: "world" in known and "track" in known)
        assert [area["role"] for area in known["world"]["areas"]] == ["goal", "wall", "wall", "obstacle", "seen"]
        assert known["track"]["pose"][0] == pytest.approx(3.9)
        assert len(known["track"]["points"]) == 40


def test_names_and_texts_arrive_as_they_are(served: Served) -> None:
    with Page(served) as page:
        page.say(kind="view", channel=MARKUP)
        details = page.until(lambda known: "details" in known)["details"]
        assert details["channel"] == MARKUP
        assert details["fields"]["reason"] == "<script>alert(2)</script>\x1b[31m"


def test_a_log_obeys(served: Served) -> None:
    with Page(served) as page:
        page.say(kind="log", action="seek", value=1.0)
        page.until(lambda known: known.get("state", {}).get("log", {}).get("at_s") == pytest.approx(1.0))
        page.say(kind="view", channel="robot.image")
        page.say(kind="log", action="step", value=1)
        page.until(lambda known: known["state"]["log"]["at_s"] == pytest.approx(1.1))
        page.say(kind="log", action="speed", value=5)
        page.say(kind="log", action="play")
        known = page.until(lambda known: known["state"]["log"]["at_s"] == pytest.approx(3.9))
        assert known["state"]["log"]["speed"] == 5
        page.until(lambda known: known["state"]["log"]["playing"] is False)


def test_a_page_that_draws_nothing_is_sent_nothing_more(served: Served) -> None:
    with Page(served) as idle, Page(served) as busy:
        first = json.loads(idle.socket.recv(20))
        assert first["number"] == 1
        for _ in range(3):
            busy.update()
            busy.say(kind="log", action="seek", value=1.0)
        with pytest.raises(TimeoutError):
            idle.socket.recv(0)


def test_pages_are_few(served: Served) -> None:
    pages = [Page(served) for _ in range(8)]
    with pytest.raises(InvalidStatus) as refused:
        Page(served)
    assert refused.value.response.status_code == 503
    for page in pages:
        page.close()
