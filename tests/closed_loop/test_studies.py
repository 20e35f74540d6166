"""A study gives the same results however it is made: by one process, by two, by a cluster, killed in between."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from graphnav.core.cli import main
from tests.forked_commands import forked_graphnav

pytestmark = pytest.mark.long
SCRIPTS = Path(sysconfig.get_path("scripts"))
STUDY = ["corridor_ccw", "--vary", "plane=plane.ica,plane.affine", "--gallery", "0"]
SHORT, LONG = (["--set", f"run.until_s={until_s}"] for until_s in (0.5, 30))


DEADLY = """
import os, signal
from graphnav import Source, Twist, hookimpl, param

FAMILY = "deadly"

class Walker(Source):
    after: int = param(5, doc="dies at this tick")

    def reset(self, seed: int) -> None:
        self.ticks = 0

    def step(self) -> Twist:
        self.ticks += 1
        if self.ticks == self.after:
            os.kill(os.getpid(), signal.SIGKILL)
        return Twist(v_mps=0.0, omega_radps=0.0)

@hookimpl
def graphnav_stages():
    return [Walker]
"""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the results of the study, made by one process."""
    folder = tmp_path_factory.mktemp("study")
    assert main(["ablate", *STUDY, *SHORT, "--seeds", "0:2", "-o", str(folder / "one"), "-j", "1"]) == 0
    return (folder / "one" / "results.csv").read_bytes()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Return the address of a Dask scheduler with two workers of a thread each, real processes on loopback."""
    folder = tmp_path_factory.mktemp("dask")
    with ExitStack() as stack:
        scheduler = stack.enter_context(process("dask", "scheduler", "--port", "0", "--host", "127.0.0.1"))
        stack.callback(scheduler.terminate)
        assert scheduler.stderr is not None
        address = next(found.group() for line in scheduler.stderr if (found := re.search(r"tcp://[\d.]+:\d+", line)))
        workers = []
        for name in ("first", "second"):
            words = ["--no-nanny", "--local-directory", str(folder / name)]  # nothing restarts one that dies
            workers.append(stack.enter_context(process("dask", "worker", address, "--nthreads", "1", *words)))
            stack.callback(workers[-1].terminate)
        for worker in workers:  # a study gives up where no worker comes for some seconds
            assert worker.stderr is not None
            assert any("Registered to" in line for line in worker.stderr)
        yield address


def process(program: str, *words: str) -> subprocess.Popen[str]:
    """Start one of Dask's programs."""
    command = [str(SCRIPTS / program), *words, "--no-dashboard"]
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}  # every 10 ms
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def start(
    folder: Path, *words: str, until: list[str] = SHORT, program: Path = SCRIPTS / "graphnav"
) -> subprocess.Popen[str]:
    """Start the study as the leader of a process group."""
    command = [str(program), "ablate", *STUDY, *until, "--seeds", "0:2", "-o", str(folder), *words]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def wait_until(condition: Callable[[], bool], study: subprocess.Popen[str]) -> None:
    """Wait until a condition holds or the study has ended, for at most a minute."""
    deadline = time.monotonic() + 60
    while not condition() and study.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)


def finished(folder: Path, *words: str, program: Path = SCRIPTS / "graphnav") -> bytes:
    """Run the study to its end and return its results."""
    study = start(folder, *words, program=program)
    _, said = study.communicate()
    assert (study.returncode, said) == (0, "")
    return (folder / "results.csv").read_bytes()


def test_two_processes_and_thread_counts_from_outside_change_no_result(
    undisturbed: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"):
        monkeypatch.setenv(name, "4")
    assert finished(tmp_path / "two", "-j", "2") == undisturbed
    assert undisturbed.count(b"\n") == 5


def test_a_cluster_gives_the_same_results(undisturbed: bytes, tmp_path: Path, cluster: str) -> None:
    assert finished(tmp_path / "cluster", "--cluster", cluster, program=forked_graphnav()) == undisturbed


def test_a_stage_that_kills_its_process_kills_no_worker_of_a_cluster(tmp_path: Path, cluster: str) -> None:
    plugin, graph = tmp_path / "deadly.py", tmp_path / "walk.yaml"
    plugin.write_text(DEADLY)
    graph.write_text("run: {until_s: 1}\nstages: {robot: {use: deadly.walker}}\n")
    results = []
    for words in (["-j", "2"], ["--cluster", cluster]):
        out = tmp_path / words[0].strip("-")
        command = [str(forked_graphnav()), "ablate", str(graph), "--plugin", str(plugin), "--seeds", "0:2"]
        command += ["--vary", "robot.after=1000,5", "-o", str(out), *words]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        assert done.returncode == 0
        said = done.stderr.splitlines()
        assert len(said) == 4, "of each of two runs its cause, and where it is"
        assert done.stderr.count("failed: ") == done.stderr.count("its process died, twice") == 2
        results.append((out / "results.csv").read_text())
    assert results[0] == results[1]
    assert results[0].count("its process died, twice") == 4, "cause and failure of two runs"


def test_kill_9_at_any_moment_changes_no_result(undisturbed: bytes, tmp_path: Path) -> None:
    out = tmp_path / "killed"
    for made in (1, 3):
        study = start(out, "-j", "2")
        wait_until(lambda: len(list(out.glob("runs/*/*/*"))) >= made, study)  # noqa: B023 - called before it changes
        os.killpg(study.pid, signal.SIGKILL)
        study.communicate()
    assert main(["ablate", *STUDY, *SHORT, "--seeds", "0:2", "-o", str(out), "-j", "2"]) == 0
    assert (out / "results.csv").read_bytes() == undisturbed


def test_ctrl_c_on_a_cluster_is_clean(tmp_path: Path, cluster: str) -> None:
    out = tmp_path / "stopped"
    study = start(out, "--cluster", cluster, until=LONG, program=forked_graphnav())
    wait_until((out / ".scratch").exists, study)
    os.killpg(study.pid, signal.SIGINT)
    assert study.communicate() == ("", "stopped: 0 of 4 runs are finished; resume with the same command\n")
    assert study.returncode == 130


def test_without_dask_it_is_said_what_to_install(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['distributed'] = None\n"
        "from graphnav.core.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    words = ["ablate", *STUDY, "--seeds", "0:1", "-o", str(tmp_path / "out"), "--cluster", "tcp://127.0.0.1:1"]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, "--cluster needs Dask\n  pip install 'distributed>=2024.4'\n")
