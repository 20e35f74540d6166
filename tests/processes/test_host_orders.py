"""Orders on the standard input of a host's command, and their end."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from graphnav import UserError
from graphnav.processes import host_orders
from graphnav.processes.host_key import new_key
from graphnav.processes.host_orders import ALIVE, Orders, is_waiting, orders, waiting


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Return the descriptor of the one who gives orders, in a list from which a test takes it that closes it."""
    given, giver = os.pipe()
    monkeypatch.setattr(host_orders, "_STDIN", given)
    left = [giver]
    yield left
    for fd in (given, *left):
        os.close(fd)


def test_orders_end_with_the_one_who_gives_them(told: list[int]) -> None:
    key = new_key()
    os.write(told[0], orders(7669, key) + ALIVE)
    got = Orders()
    assert (got.port, got.key) == (7669, key)
    assert not got.are_over()
    os.close(told.pop())
    assert got.are_over()


def test_orders_end_in_silence(told: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    os.write(told[0], orders(7669, new_key()))
    got = Orders()
    monkeypatch.setattr(host_orders, "SILENT_S", 0.0)
    assert got.are_over()


@pytest.mark.parametrize(
    "said", [b"", b"\n", b"7669\n", b'{"port": 7669, "key": "00"}\n', b'{"port": [], "key": 1}\n', b"x" * 600]
)
def test_something_else_is_refused(told: list[int], said: bytes) -> None:
    os.write(told[0], said)
    os.close(told.pop())
    with pytest.raises(UserError, match=r"--key -: no port and key came on standard input"):
        Orders()


def test_a_line_of_something_else_does_not_say_that_it_waits() -> None:
    assert is_waiting(waiting(7669).encode() + b"\n")
    assert not any(map(is_waiting, (b"Welcome to jetson\n", b"7\n", b"[" * 100_000, b"\xff\n", b"{}\n")))
