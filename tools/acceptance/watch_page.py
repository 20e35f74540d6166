"""The page: served to this machine and its own pages only, names never as markup; shown by the tests of the page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO

import pytest

from acceptance.drives import say
from acceptance.machine import ROOT

PROMISES = {
    "binds 127.0.0.1 by default": ("test_command.py::test_it_prints_where_the_page_is_and_ends_with_ctrl_c",),
    "answers 404 outside its routes": (
        "test_server.py::test_all_else_is_not_found",
        "test_server.py::test_updates_are_no_file",
    ),
    "refuses WebSockets of other origins, and other hosts": (
        "test_server.py::test_pages_of_other_origins_are_refused",
        "test_server.py::test_a_wrong_host_is_refused",
        "test_hosts.py",
    ),
    "survives requests and orders that are garbage": (
        "test_server.py::test_other_methods_and_garbage_end_the_connection_and_nothing_else",
        "test_server.py::test_what_is_not_an_order_ends_the_connection",
    ),
    "hands on names and strings as they are": ("test_server.py::test_names_and_texts_arrive_as_they_are",),
    "shows names and strings as text, in Chromium": ("test_page.py::test_names_and_texts_are_never_markup",),
    "asks for nothing beyond its own server, in Chromium": (
        "test_page.py::test_it_asks_for_nothing_elsewhere_and_complains_about_nothing",
        "test_server.py::test_the_page_asks_for_nothing_elsewhere",
    ),
}
"""The promises, and the tests under tests/watch/view that show them."""


def page_item(_seeds: Sequence[int], _jobs: int) -> bool:
    """Run the tests of all promises; print how many passed of each. One without Chromium is skipped, and so not met."""
    ends = _Ends()
    tests = {f"tests/watch/view/{test}" for tests in PROMISES.values() for test in tests}
    with redirect_stdout(StringIO()):
        pytest.main(["-q", f"--rootdir={ROOT}", *(str(ROOT / test) for test in sorted(tests))], plugins=[ends])
    kept = [_is_kept(promise, tests, ends) for promise, tests in PROMISES.items()]
    for failure in ends.failures:
        say(failure)
    return all(kept)


class _Ends:
    """Collects how tests end, as a plugin of pytest."""

    def __init__(self) -> None:
        self.outcomes: dict[str, str] = {}
        self.failures: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep how a test's call ended, or what went wrong before or behind it."""
        if report.when == "call" or not report.passed:
            self.outcomes[report.nodeid] = report.outcome
        if report.failed:
            self.failures.append(f"{report.nodeid}\n{report.longreprtext}")


def _is_kept(promise: str, tests: Sequence[str], ends: _Ends) -> bool:
    starts = tuple(f"tests/watch/view/{test}" for test in tests)
    counts = Counter(outcome for name, outcome in ends.outcomes.items() if name.startswith(starts))
    good = set(counts) == {"passed"}
    text = ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())) or "no test ran"
    say(f"{'ok  ' if good else 'MISS'} the page {promise}: {text}")
    return good
