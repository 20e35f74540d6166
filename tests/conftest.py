"""Fixtures of all tests: among them a catalog of toy stages, for the tests of graphs."""

from __future__ import annotations

import gc
import math
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import hypothesis
import pytest

from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.errors import BusError
from graphnav.core.graph import Graph, Override, graph_of
from tests.forked_commands import FOLDER
from tests.targets import Targets

TOYS = Path(__file__).parent / "errors" / "stages.py"

LOOP = """\
about: A toy that sees noise.
run: {until_s: 1, seed: 3}
stages:
  robot: {use: toy.robot, in: {command: wheels.twist}}
  flow: {use: toy.matcher, in: {image: robot.image}}
  plane: {use: toy.detector, with: {rule: otsu}, in: {flow: flow}}
  wheels: {use: toy.wheels, in: {plane: plane.plane}}
  score: {use: toy.score, in: {plane: plane.plane, motion: robot.motion}}
"""

_FIRST_PORT, _N_PORTS = 10_000, 20_000
"""Linux hands datagrams of all groups to every listener on a port, so each process of the tests has its own port."""
_SLOW = Path(__file__).parent / "slow"
_LATEST_S = pytest.StashKey[float]()
_URL = f"udpm://239.255.77.{os.getpid() % 250 + 1}:{_FIRST_PORT + os.getpid() % _N_PORTS}?ttl=0"
_FAR_PORT = _FIRST_PORT + (os.getpid() + _N_PORTS // 2) % _N_PORTS
_FAR_URL = f"udpm://239.255.78.{os.getpid() % 250 + 1}:{_FAR_PORT}?ttl=0"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare what ``tools/check.py quick`` limits the time with, and what tests that take minutes to hours need."""
    parser.addoption("--within-s", type=float, help="skip tests that would begin later, counted from the first")
    slow = parser.getgroup("slow tests")
    slow.addoption(
        "--slow", action="store_true", help="run the tests marked slow, which print what they measure, and no others"
    )
    slow.addoption("--seeds", default="1000:1020", help="FIRST:END, END excluded, of slow tests (default 1000:1020)")
    slow.addoption("--jobs", type=int, default=2, help="drives at a time in a slow test (default 2)")
    slow.addoption("--kills", type=int, default=20, help="how often a slow test kills each stage (default 20)")
    slow.addoption("--minutes", type=float, default=30, help="how long a slow test lets a run go on (default 30)")


def pytest_configure(config: pytest.Config) -> None:
    """Keep tests that run at the same time, and the user's trust and cache, apart; let tests' processes be interrupted.

    A background job ignores these signals, and hands that on. Property tests try the same examples in every run.
    """
    os.environ["LCM_DEFAULT_URL"] = _URL
    os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="graphnav-state-")
    os.environ.pop("COLUMNS", None)  # pytest-xdist sets it, and tables would be as narrow
    caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    os.environ.setdefault("MPLCONFIGDIR", os.path.join(caches, "matplotlib"))  # its list of fonts takes seconds
    os.environ["XDG_CACHE_HOME"] = cache = tempfile.mkdtemp(prefix="graphnav_tests_")
    config.add_cleanup(lambda: shutil.rmtree(cache, ignore_errors=True))
    if FOLDER not in os.environ:  # workers have that of their parent
        os.environ[FOLDER] = forks = tempfile.mkdtemp(prefix="graphnav_forks_")
        config.add_cleanup(lambda: shutil.rmtree(forks, ignore_errors=True))
    hypothesis.settings.register_profile("any machine", deadline=None, derandomize=True)
    hypothesis.settings.load_profile("any machine")
    for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)


def pytest_itemcollected(item: pytest.Item) -> None:
    """Give a slow test all the time that it takes."""
    if item.get_closest_marker("slow"):
        item.add_marker(pytest.mark.timeout(0))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out the folder of slow tests unless they are asked for."""
    return True if collection_path == _SLOW and not config.getoption("--slow") else None


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the slow tests or the others. Start modules with long tests first, as many a worker.

    Worksteal cuts the list into equal parts. Those of a folder stay together, in whatever order: they import the same,
    and have the same workers of studies.
    """
    is_slow = bool(config.getoption("--slow"))
    left_out = [item for item in items if bool(item.get_closest_marker("slow")) != is_slow]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if bool(item.get_closest_marker("slow")) == is_slow]
    modules: dict[str, list[pytest.Item]] = {}
    for item in items:
        modules.setdefault(item.nodeid.partition("::")[0], []).append(item)
    is_long = {name: any(item.get_closest_marker("long") for item in of) for name, of in modules.items()}
    n_workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    first = [name for name in modules if is_long[name]]
    folders = list(dict.fromkeys(map(_folder, modules)))
    not_long = (name for name in modules if not is_long[name])
    others = deque(sorted(not_long, key=lambda name: folders.index(_folder(name))))
    ordered: list[pytest.Item] = []
    for worker in range(n_workers):
        for name in first[worker::n_workers]:
            ordered += modules[name]
        while others and (worker == n_workers - 1 or len(ordered) * n_workers < len(items) * (worker + 1)):
            ordered += modules[others.popleft()]
    items[:] = ordered


def _folder(module: str) -> str:
    """Return the folder of ``tests`` in which a module is, or else the module."""
    return "/".join(module.split("/")[:2])


@pytest.hookimpl(tryfirst=True)
def pytest_collection() -> None:
    """Look for no garbage while ten thousand tests are collected, nor ever among them: a third of the time."""
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Remember when tests are no longer to begin."""
    gc.freeze()
    gc.enable()
    within_s = session.config.getoption("--within-s")
    session.config.stash[_LATEST_S] = math.inf if within_s is None else time.monotonic() + within_s


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what would begin too late."""
    if time.monotonic() > item.config.stash[_LATEST_S]:
        pytest.skip("not begun in time; python tools/check.py tests runs all")


def pytest_unconfigure() -> None:
    """Remove what the tests trusted."""
    shutil.rmtree(os.environ["XDG_STATE_HOME"], ignore_errors=True)


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, object, object]:
    """Fail a test that misses a target."""
    result = yield
    targets = pyfuncitem.funcargs.get("targets")
    if isinstance(targets, Targets) and targets.missed:
        pytest.fail("\n".join(["missed:", *targets.missed]), pytrace=False)
    return result


@pytest.fixture
def targets(request: pytest.FixtureRequest) -> Targets:
    """Return the printer of what this test measures, whatever pytest captures."""
    capture = request.config.pluginmanager.getplugin("capturemanager")

    def show(text: str) -> None:
        with capture.global_and_fixture_disabled():
            print(text, flush=True)

    show(f"\n== {request.node.name}")
    return Targets(show)


@pytest.fixture(scope="session")
def study_workers() -> Iterator[None]:
    """Let all studies of this process have the same workers."""
    from tests.kept_workers import kept_workers

    with kept_workers():
        yield


@contextmanager
def _disk_of(n_bytes: int) -> Iterator[None]:
    old, ignored = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    has_compiled, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # Python would keep half a compiled module
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, old[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
        sys.dont_write_bytecode = has_compiled
        signal.signal(signal.SIGXFSZ, ignored)


@pytest.fixture
def disk_of() -> Callable[[int], AbstractContextManager[None]]:
    """Return what lets no file grow beyond some bytes: the kernel then refuses as it does where the disk is full."""
    return _disk_of


@pytest.fixture(scope="session")
def group() -> str:
    """Return the multicast group of this process, where its runs are tapped; skip where there is no route."""
    try:
        Bus.require_route(_URL)
    except BusError as error:
        pytest.skip(str(error))
    return _URL


@pytest.fixture(scope="session")
def far_group(group: str) -> str:
    """Return a second multicast group of this process, which stands in for that of another host."""
    return _FAR_URL


@pytest.fixture(scope="session")
def toys() -> Catalog:
    """Return a catalog with the family ``toy``."""
    catalog = Catalog()
    catalog.add_file(TOYS)
    return catalog


@pytest.fixture
def load(toys: Catalog, tmp_path: Path) -> Callable[..., Graph]:
    """Return a function that loads the text of a graph, as if it stood in an empty folder."""

    def loaded(text: str = LOOP, *sets: str) -> Graph:
        return graph_of(text.encode(), tmp_path / "graph.yaml", toys, [*map(Override.parse, sets)], "graph.yaml")

    return loaded
