"""A page of another site cannot reach the server, whatever name it gives us."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphnav.watch.view.web.hosts import Hosts, is_loopback, url_of

OWN = ["127.0.0.1:7667", "localhost:7667", "LOCALHOST:7667", "[::1]:7667"]
STRANGE = [
    "evil.example:7667",
    "127.0.0.1",
    "127.0.0.1:80",
    "127.0.0.1.evil.example:7667",
    "evil@127.0.0.1:7667",
    "127.0.0.1:7667/",
    "127.0.0.1:07667x",
    "192.168.1.7:7667",
    "",
    ":7667",
    "[::1",
]


@pytest.mark.parametrize("host", OWN)
def test_this_machine_is_admitted_by_its_own_names(host: str) -> None:
    assert Hosts("127.0.0.1", 7667).admits([host])


@pytest.mark.parametrize("host", STRANGE)
def test_any_other_name_is_refused(host: str) -> None:
    assert not Hosts("127.0.0.1", 7667).admits([host])


def test_there_is_exactly_one_name() -> None:
    hosts = Hosts("127.0.0.1", 7667)
    assert not hosts.admits([])
    assert not hosts.admits([OWN[0], OWN[0]])


def test_on_all_interfaces_addresses_are_admitted_and_foreign_names_are_not() -> None:
    hosts = Hosts("0.0.0.0", 7667)
    assert hosts.admits(["192.168.1.7:7667"])
    assert hosts.admits(["[fe80::1]:7667"])
    assert not hosts.admits(["evil.example:7667"])


def test_a_chosen_address_is_admitted() -> None:
    assert Hosts("192.168.1.7", 80).admits(["192.168.1.7"])
    assert not Hosts("192.168.1.7", 80).admits(["192.168.1.8"])


def test_only_pages_of_this_server_are_its_own() -> None:
    hosts = Hosts("127.0.0.1", 7667)
    assert hosts.admits_origin(["http://127.0.0.1:7667"], "127.0.0.1:7667")
    for origin in ("https://127.0.0.1:7667", "http://localhost:7667", "http://evil.example", "null", ""):
        assert not hosts.admits_origin([origin], "127.0.0.1:7667")
    assert not hosts.admits_origin([], "127.0.0.1:7667")


@given(st.lists(st.text(), max_size=3))
def test_no_header_raises(hosts: list[str]) -> None:
    Hosts("127.0.0.1", 7667).admits(hosts)


def test_addresses() -> None:
    assert all(map(is_loopback, ("127.0.0.1", "localhost", "::1")))
    assert not any(map(is_loopback, ("0.0.0.0", "192.168.1.7", "robot.local")))
    assert url_of("0.0.0.0", 1) == "http://127.0.0.1:1/"
    assert url_of("::1", 1) == "http://[::1]:1/"
