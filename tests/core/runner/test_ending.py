"""However a run ends, its log is complete and its summary states the outcome."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.runner.recording.summary import Summary
from tests.forked_commands import forked_graphnav

STAGES = Path(__file__).parent / "stages.py"
Run = Callable[..., tuple[Summary, Recording]]

BAD = """
run: {{until_s: 2}}
stages:
  c: {{use: probe.counter}}
  b: {{use: probe.{use}, in: {{twist: c.twist}}}}
"""


@pytest.mark.parametrize(
    ("use", "message", "raised"),
    [
        ("bad, with: {what: raise}", "(probe.bad) failed at 0.30 s: KeyError: 'there is no such\\nthing'", "KeyError"),
        ("bad, with: {what: exit}", "(probe.bad) failed at 0.30 s: SystemExit: 3", "SystemExit"),
        ("bad, with: {what: type}", "(probe.bad) failed at 0.30 s: output 'image' is Goal, not Image", ""),
        ("nan", "(probe.nan) failed at 0.00 s: output 'twist' holds a NaN or an infinity in 'v_mps'", ""),
    ],
)
def test_a_stage_that_fails_is_named_with_what_it_raised(run: Run, use: str, message: str, raised: str) -> None:
    summary, log = run(BAD.format(use=use))
    assert summary.outcome == "failed"
    what, *where = summary.failure.splitlines()
    assert what == f"stage 'b' {message}"
    assert [re.sub(r":\d+ ", " ", line) for line in where] == ([f"  {raised} at stages.py in step"] if raised else [])
    assert log.truncated is None
    assert log.count("c.twist") == summary.frames + 1


def test_an_array_that_does_not_fit_its_type_is_named(run: Run) -> None:
    summary, _ = run(BAD.format(use="bad, with: {what: shape}"))
    assert summary.outcome == "failed"
    assert summary.failure.startswith("stage 'b' (probe.bad) failed at 0.30 s: output 'image': ")
    assert "complex" in summary.failure


def test_a_message_that_cannot_be_read_names_the_stage_that_wrote_it(run: Run) -> None:
    summary, _ = run(BAD.format(use="bad, with: {what: empty}") + "  look: {use: probe.look, in: {image: b.image}}")
    assert summary.outcome == "failed"
    said = "stage 'b': output 'image' is not of type Image: rows is 0, expected 1 or more"
    assert summary.failure == said


def start(folder: Path, text: str, *words: str) -> subprocess.Popen[str]:
    """Start a run in a process of its own."""
    graph = folder / "graph.yaml"
    graph.write_text(text)
    command = [
        str(forked_graphnav()),
        "run",
        str(graph),
        "--plugin",
        str(STAGES),
        "--no-tap",
        "-o",
        str(folder / "out"),
        *words,
    ]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for_log(process: subprocess.Popen[str], log: Path) -> None:
    """Return once the run has written to its log."""
    deadline = time.monotonic() + 60
    while process.poll() is None and time.monotonic() < deadline and not (log.exists() and log.stat().st_size):
        time.sleep(0.005)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_a_run_with_log_and_summary(tmp_path: Path, number: int) -> None:
    process = start(tmp_path, BAD.format(use="plus").replace("until_s: 2", "until_s: 1e6"), "--pace", "5")
    wait_for_log(process, tmp_path / "out" / "run.lcmlog")
    assert_stopped(process, tmp_path / "out", number)


def test_ctrl_c_breaks_off_a_step_that_hangs(tmp_path: Path) -> None:
    process = start(tmp_path, BAD.format(use="bad, with: {what: hang}"), "--no-pictures")
    assert process.stderr is not None
    assert process.stderr.readline() == "hanging\n"
    assert_stopped(process, tmp_path / "out", signal.SIGINT, wants_pictures=False)


def assert_stopped(process: subprocess.Popen[str], folder: Path, number: int, *, wants_pictures: bool = True) -> None:
    """Interrupt a run and see that it leaves everything."""
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, out + err
    assert "Traceback" not in err
    assert (f"no pictures were drawn; to draw them, run: graphnav figure {folder}" in err) == wants_pictures
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["outcome"] == "stopped"
    log = Recording(folder / "run.lcmlog")
    assert log.truncated is None
    assert log.count("c.twist") >= summary["frames"] > 0


def test_a_killed_run_leaves_a_readable_log(tmp_path: Path) -> None:
    process = start(tmp_path, BAD.format(use="plus").replace("until_s: 2", "until_s: 1e6"), "--pace", "5")
    wait_for_log(process, tmp_path / "out" / "run.lcmlog")
    process.kill()
    process.communicate()
    assert Recording(tmp_path / "out" / "run.lcmlog").count("c.twist") > 0


def test_a_failure_has_exit_status_1_and_shows_its_cause_only_when_asked(tmp_path: Path) -> None:
    (tmp_path / "short").mkdir()
    process = start(tmp_path / "short", BAD.format(use="bad"))
    out, err = process.communicate()
    assert process.returncode == 1, out + err
    assert "stage 'b' (probe.bad) failed at 0.30 s" in err
    assert "Traceback" not in err
    (tmp_path / "long").mkdir()
    process = start(tmp_path / "long", BAD.format(use="bad"), "-v")
    _, err = process.communicate()
    assert process.returncode == 1
    assert "KeyError" in err
    assert "Traceback" in err


def test_a_folder_that_is_not_empty_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "precious").write_text("mine")
    process = start(tmp_path, BAD.format(use="plus"))
    _, err = process.communicate()
    assert process.returncode == 2
    assert f"{tmp_path / 'out'} is not empty" in err
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["precious"]


FULL = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, 400_000))
sys.dont_write_bytecode = True
from graphnav.core.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_a_disk_that_takes_no_more_is_reported_and_the_log_stays_readable(tmp_path: Path) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text("run: {until_s: 60}\nstages: {n: {use: probe.noise, with: {rate_hz: 100}}}")
    command = [sys.executable, "-c", FULL, "run", str(graph), "--plugin", str(STAGES), "--no-tap", "--no-pictures"]
    done = subprocess.run([*command, "-o", str(tmp_path / "out")], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "run.lcmlog: File too large" in done.stderr
    assert "Traceback" not in done.stderr
    log = Recording(tmp_path / "out" / "run.lcmlog")
    assert log.truncated is None
    assert log.count("n.image") > 100
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "failed"
