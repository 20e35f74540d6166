"""Numbers of options: each is used or refused in one line, however extreme it is."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.cli.quantities import port_number, positive
from graphnav.core.parameters import COUNT, SEED_NUMBER, Integer, seconds
from graphnav.watch.commands.quantities import log_time, period, size, split

NUMBERS = ["nan", "inf", "-inf", "1e308", "1e-300", "-1", "0", "9" * 5000, "1e400", "", "x", "²", "٣", "0x10", "1_0"]
UNITS = ["", "s", "min", "h", "kB", "TiB"]
PARSERS: list[Callable[[str], object]] = [
    *(COUNT, SEED_NUMBER, Integer(0), positive, seconds, log_time, size, split, period, port_number),
]


@pytest.mark.parametrize("parse", PARSERS)
def test_a_number_is_parsed_or_refused(parse: Callable[[str], object]) -> None:
    for number, unit in itertools.product(NUMBERS, UNITS):
        found: object = 0
        with suppress(argparse.ArgumentTypeError):
            found = parse(number + unit)
        assert not isinstance(found, int | float) or 0 <= found <= 1e18


@pytest.mark.parametrize("option", ["--pace", "--seed", "--until"])
def test_extreme_options_of_a_run_are_refused(option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in ("1e-300", "1e308", "-1e308", "nan", "-inf", "9" * 400):
        try:
            status = main(["run", "corridor_ccw", "-o", str(tmp_path / "run"), f"{option}={number}", "--no-tap"])
        except SystemExit as error:  # of argparse
            status = int(str(error.code))
        assert status == 2 or number == "1e-300"
        assert option in capsys.readouterr().err or status == 0
