"""Sizes and times are parsed and formatted with units."""

from __future__ import annotations

from argparse import ArgumentTypeError

import pytest

from graphnav.core.record.log_files import Split
from graphnav.watch.commands.quantities import log_time, size, split


@pytest.mark.parametrize(
    ("text", "n_bytes"),
    [("100MB", 100_000_000), ("2GiB", 2 << 30), ("1.5kB", 1500), ("7 b", 7), ("0.5 KiB", 512), ("1TB", 10**12)],
)
def test_sizes(text: str, n_bytes: int) -> None:
    assert size(text) == n_bytes
    assert split(text) == Split(n_bytes=n_bytes)


@pytest.mark.parametrize(("text", "time_s"), [("12.3s", 12.3), ("12.3", 12.3), ("0", 0), ("2min", 120), ("1h", 3600)])
def test_times(text: str, time_s: float) -> None:
    assert log_time(text) == time_s


def test_a_split_by_time() -> None:
    assert split("60s") == Split(us=60_000_000)
    assert split("1.5 min") == Split(us=90_000_000)


@pytest.mark.parametrize("text", ["", "MB", "100", "1e3MB", "-1MB", "1.2.3MB", "100 M", "nan", "0MB", "9" * 400 + "MB"])
def test_what_is_not_a_size_is_refused(text: str) -> None:
    with pytest.raises(ArgumentTypeError):
        size(text)


@pytest.mark.parametrize("text", ["", "s", "-1", "nan", "inf", "1:30", "12 years", "9" * 400])
def test_what_is_not_a_time_is_refused(text: str) -> None:
    with pytest.raises(ArgumentTypeError):
        log_time(text)


@pytest.mark.parametrize("text", ["", "60", "0s", "0MB", "often", "-5s"])
def test_what_is_not_a_split_is_refused(text: str) -> None:
    with pytest.raises(ArgumentTypeError, match="is not a size or time: write 100MB or 60s"):
        split(text)
