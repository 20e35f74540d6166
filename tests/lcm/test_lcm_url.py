"""Which LCM URL is used: the one given, that of the environment, or this machine's group."""

from __future__ import annotations

import socket
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from graphnav.core.bus import Bus
from graphnav.core.cli import main
from graphnav.core.errors import UserError
from graphnav.core.lcm_url import lcm_url, tap_url
from graphnav.watch.feed import Feed

_BUFFER = "&recv_buf_size=2097152"


@pytest.mark.parametrize(
    ("environment", "choices", "url"),
    [
        ("", (), Bus.GROUP + _BUFFER),
        ("udpm://239.1.1.1:7001", (), "udpm://239.1.1.1:7001?ttl=0" + _BUFFER),
        ("udpm://239.1.1.1", (), "udpm://239.1.1.1:7667?ttl=0" + _BUFFER),
        ("udpm://239.1.1.1:7001?ttl=1", (("--url", None),), "udpm://239.1.1.1:7001?ttl=1" + _BUFFER),
        ("udpm://239.1.1.1:7001", (("--url", None), ("run.url", "udpm://239.1.1.2:7002?recv_buf_size=9")), ""),
        ("nonsense", (("--url", "udpm://239.1.1.3:7003"),), "udpm://239.1.1.3:7003?ttl=0" + _BUFFER),
    ],
)
@pytest.mark.usefixtures("group")
def test_the_first_that_is_given_is_used(
    environment: str, choices: tuple[tuple[str, str | None], ...], url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LCM_DEFAULT_URL", environment)
    assert lcm_url(*choices) == (url or "udpm://239.1.1.2:7002?ttl=0&recv_buf_size=9")


@pytest.mark.parametrize(
    ("environment", "url"),
    [
        ("", Bus.GROUP),
        ("udpm://", Bus.GROUP),
        ("udpm://239.1.1.1", "udpm://239.1.1.1:7667?ttl=0"),
        ("udpm://239.1.1.1:7001", "udpm://239.1.1.1:7001?ttl=0"),
        ("udpm://239.1.1.1:7001?ttl=3&recv_buf_size=9", "udpm://239.1.1.1:7001?ttl=0&recv_buf_size=9"),
    ],
)
@pytest.mark.usefixtures("group")
def test_runs_are_tapped_and_watched_on_the_same_group_and_on_this_machine_only(
    environment: str, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LCM_DEFAULT_URL", environment)
    assert tap_url() == Feed(None).name == url


@pytest.mark.parametrize(
    ("environment", "what"),
    [
        ("memq://", "'memq://' is not a udpm:// URL"),
        ("udpm://10.0.0.1:7667", "'10.0.0.1' is not a multicast address"),
        ("udpm://239.1.1.1:0", "port 0 of 239.1.1.1 is not a port to listen on\n  write udpm://239.255.76.67:7667"),
        ("udpm://239.1.1.1:port", "LCM does not open udpm://239.1.1.1:port"),
    ],
)
def test_an_environment_that_leads_nowhere_is_told(
    environment: str, what: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LCM_DEFAULT_URL", environment)
    with pytest.raises(UserError) as error:
        lcm_url()
    assert str(error.value).startswith(f"LCM_DEFAULT_URL: {what}")
    assert main(["spy", "--once"]) == 2
    assert capsys.readouterr().err.startswith(f"LCM_DEFAULT_URL: {what}")


def test_a_run_does_without_the_tap_where_the_environment_leads_nowhere(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: object
) -> None:
    monkeypatch.setenv("LCM_DEFAULT_URL", "memq://")
    out = f"{tmp_path}/run"
    assert main(["run", "corridor_ccw", "--until", "0.2", "--no-pictures", "-o", out]) == 0
    assert "no tap: LCM_DEFAULT_URL: 'memq://' is not a udpm:// URL" in capsys.readouterr().out


def test_where_lcm_cannot_listen_watchers_end_and_a_run_does_without_the_tap(
    group: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    run = ["run", "corridor_ccw", "--until", "0.2", "--no-pictures", "-o", str(tmp_path / "run")]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("", 0))
        monkeypatch.setenv("LCM_DEFAULT_URL", f"udpm://{urlsplit(group).hostname}:{taken.getsockname()[1]}")
        said = f"LCM cannot listen on {lcm_url()}: its port is in use, or LCM's self test of the network failed\n"
        for words in (["spy", "--once"], ["hz", "x"], ["echo", "x"], ["record", "-o", str(tmp_path / "log")]):
            assert main([*words, "--for", "1"]) == 1
            assert capsys.readouterr().err == f"{said}  choose another port, or run: graphnav doctor\n"
        assert main(run) == 0
    assert f"no tap: {said}" in capsys.readouterr().out
