"""Code of plugins cannot end a run or graphnav: it is named in one line, and the record is complete."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sysconfig
from collections.abc import Callable
from pathlib import Path

import pytest

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.errors import CatalogError, DrawingError, UserError
from graphnav.core.graph import Graph, load_graph
from graphnav.core.interrupts import CtrlC, third_party_code
from graphnav.core.pictures import drawing
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner.recording.progress_file import ProgressFile
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.spec.declared.file_format import plugin_formats
from tests.core.runner.misbehaving import KINDS, SUMMARIES
from tests.forked_commands import forked_graphnav

PLUGIN = Path(__file__).with_name("misbehaving.py")
GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
HOOKS = {
    "import": "misbehave({!r})",
    "graphnav_stages": "@hookimpl\ndef graphnav_stages():\n    misbehave({!r})",
    "graphnav_adapters": "@hookimpl\ndef graphnav_adapters():\n    misbehave({!r})",
    "graphnav_file_formats": "@hookimpl\ndef graphnav_file_formats():\n    misbehave({!r})",
}

GRAPH = """
run: {{until_s: 1}}
stages:
  c: {{use: odd.clock{clock}}}
  good: {{use: odd.faulty, in: {{twist: c.twist}}}}
  b: {{use: odd.{use}, in: {{twist: c.twist}}}}
"""


def graph_text(use: str, clock: str = "") -> str:
    """Return the graph of a stage ``b``."""
    return GRAPH.format(use=use, clock=clock)


def faulty(kind: str, method: str) -> str:
    """Return the graph of a stage that misbehaves in a method."""
    return graph_text(f"faulty, with: {{kind: {kind}, method: {method}}}")


@pytest.fixture
def load(tmp_path: Path) -> Callable[[str], Graph]:
    """Return a function that loads a graph of the plugin."""

    def load_text(text: str) -> Graph:
        path = tmp_path / "graph.yaml"
        path.write_text(text)
        catalog = Catalog()
        catalog.add_file(PLUGIN)
        return load_graph(path, catalog)

    return load_text


@pytest.fixture
def run(tmp_path: Path, load: Callable[[str], Graph]) -> Callable[[str], tuple[Summary, Recording]]:
    """Return a function that runs a graph of the plugin."""

    def run_text(text: str) -> tuple[Summary, Recording]:
        graph = load(text)
        folder = tmp_path / "run"
        folder.mkdir()
        summary = run_recorded(graph, graph.make_stages(), folder)
        assert json.loads((folder / "summary.json").read_text())["outcome"] == summary.outcome
        return summary, Recording(folder / RunFolder.LOG)

    return run_text


def is_told(failure: str) -> bool:
    """Whether a failure is a line, and a line with the exception's class, file, line and method."""
    what, raised = failure.split("\n")
    place = re.fullmatch(r"  \w+ at misbehaving\.py:\d+ in misbehave", raised)
    return is_one_line(what) and place is not None


def is_one_line(text: str) -> bool:
    """Whether a string is a single line that a terminal can show."""
    return "\n" not in text and "Traceback" not in text and len(text) < 1500


@pytest.mark.parametrize("method", ["reset", "step", "summary", "close"])
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_a_stage_raises_in_a_run_names_it_and_leaves_the_record(
    run: Callable[[str], tuple[Summary, Recording]], kind: str, method: str
) -> None:
    summary, log = run(faulty(kind, method))
    assert summary.outcome == "failed"
    assert summary.failure.startswith("stage 'b' (odd.faulty) failed at ")
    assert is_told(summary.failure)
    assert log.truncated is None
    assert log.count("c.twist") == {"reset": 0, "step": 3}.get(method, 11)
    if method != "reset":
        assert summary.scores["good"]["steps"] == log.count("c.twist")


@pytest.mark.parametrize("kind", ["exit_0", "ctrl_c", "lines"])
def test_whatever_a_source_raises_when_asked_for_its_time_names_it(
    run: Callable[[str], tuple[Summary, Recording]], kind: str
) -> None:
    summary, log = run(graph_text("faulty", f", with: {{kind: {kind}}}"))
    assert summary.failure.startswith("stage 'c' (odd.clock) failed at 0.20 s: due_us: ")
    assert is_told(summary.failure)
    assert log.count("c.twist") == 3


def test_a_source_that_is_never_due_later_is_refused(run: Callable[[str], tuple[Summary, Recording]]) -> None:
    summary, _ = run(graph_text("faulty", ", with: {kind: never_later}"))
    said = "due_us: ValueError: firing 1 is due at 0 us, not after the one before"
    assert summary.failure == f"stage 'c' (odd.clock) failed at 0.00 s: {said}"


@pytest.mark.parametrize("method", ["__init__", "check"])
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_a_stage_raises_before_a_run_names_it(load: Callable[[str], Graph], kind: str, method: str) -> None:
    with pytest.raises(UserError) as caught:
        load(faulty(kind, method)).make_stages()
    (problem,) = caught.value.problems
    assert problem.place is not None
    assert problem.what.startswith("odd.faulty cannot be made: ")
    assert is_one_line(problem.what)


@pytest.mark.parametrize("kind", SUMMARIES)
def test_a_summary_that_is_not_what_the_stage_declares_is_refused(
    run: Callable[[str], tuple[Summary, Recording]], kind: str
) -> None:
    summary, _ = run(graph_text(f"liar, with: {{kind: {kind}}}"))
    assert summary.outcome == "failed"
    assert summary.failure.startswith("stage 'b' (odd.liar) failed at 1.00 s: summary: ")
    assert is_one_line(summary.failure)
    assert summary.scores == {"good": {"steps": 11.0}}


@pytest.mark.parametrize("hook", HOOKS)
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_a_plugin_raises_names_it(tmp_path: Path, kind: str, hook: str) -> None:
    file = tmp_path / "strange.py"
    file.write_text("from tests.core.runner.misbehaving import *\nFAMILY = 'strange'\n" + HOOKS[hook].format(kind))

    def use() -> None:
        catalog = Catalog()
        catalog.add_file(file)
        catalog.adapters()
        plugin_formats(catalog)

    with pytest.raises(CatalogError, match=str(file)) as caught:
        use()
    assert is_one_line(caught.value.what)


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_a_drawing_plugin_raises_is_one_line(kind: str) -> None:
    with pytest.raises(DrawingError) as caught, drawing():
        raise KINDS[kind]
    assert is_one_line(str(caught.value))


def test_ctrl_c_in_code_of_a_plugin_stays_ctrl_c() -> None:
    with pytest.raises(CtrlC), drawing():
        os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def import_module() -> None:
    """Do what compiled modules do while they are imported: turn what is raised into an ImportError."""
    try:
        os.kill(os.getpid(), signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError from None


def test_ctrl_c_that_a_compiled_module_turns_into_an_import_error_stays_ctrl_c() -> None:
    with pytest.raises(CtrlC), third_party_code():
        import_module()


def test_ctrl_c_that_the_import_of_an_optional_module_swallows_is_raised_after_it() -> None:
    with pytest.raises(CtrlC), third_party_code(), contextlib.suppress(ImportError):
        import_module()


def test_the_working_folder_is_restored_after_code_of_a_plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with third_party_code():
        os.chdir("/")
    assert Path.cwd() == tmp_path


WORDS = ["run", "graph.yaml", "--plugin", str(PLUGIN), "--no-tap", "-o", "out"]


def command(folder: Path, text: str, *words: str, program: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a graph by the command line, in ``folder``."""
    (folder / "graph.yaml").write_text(text)
    line = [str(program or forked_graphnav()), *WORDS, *words]
    return subprocess.run(line, capture_output=True, text=True, check=False, cwd=folder)


@pytest.mark.parametrize(
    ("kind", "method", "said"),
    [
        ("exit_0", "step", "failed at 0.20 s: SystemExit: 0"),
        ("ctrl_c", "step", "failed at 0.20 s: KeyboardInterrupt"),
        ("exit_0", "close", "failed at 1.00 s: close: SystemExit: 0"),
    ],
)
def test_the_command_line_ends_with_status_1_what_was_raised_and_a_summary(
    tmp_path: Path, kind: str, method: str, said: str
) -> None:
    done = command(tmp_path, faulty(kind, method), "--no-pictures")
    assert done.returncode == 1, done.stdout + done.stderr
    failure = json.loads((tmp_path / "out" / "summary.json").read_text())["failure"]
    assert done.stderr == f"{failure}\n  -v shows the traceback\n"
    assert failure.startswith(f"stage 'b' (odd.faulty) {said}\n")
    assert is_told(failure)


@pytest.mark.parametrize("method", ["step", "__init__"])
def test_a_stage_that_changes_the_working_folder_harms_nothing(tmp_path: Path, method: str) -> None:
    done = command(tmp_path, faulty("move", method))
    assert done.returncode == 0, done.stdout + done.stderr
    assert {"graph.yaml", "run.lcmlog", "summary.json"} <= {path.name for path in (tmp_path / "out").iterdir()}


@pytest.mark.parametrize(
    ("method", "said"),
    [
        ("reset", "failed at 0.00 s: reset did not return within 1 s of wall time"),
        ("step", "failed at 0.20 s: step did not return within 1 s of wall time; given twist of 'c.twist'"),
        ("summary", "failed at 1.00 s: summary did not return within 1 s of wall time"),
        ("close", "failed at 1.00 s: close did not return within 1 s of wall time"),
    ],
)
def test_a_stage_that_hangs_ends_the_run_with_log_and_summary(tmp_path: Path, method: str, said: str) -> None:
    done = command(tmp_path, faulty("hang", method), "--stall-s", "1")
    assert done.returncode == 1, done.stdout + done.stderr
    line, hint = done.stderr.splitlines()
    assert line == f"stage 'b' (odd.faulty) {said}"
    assert hint == "  the log up to there and summary.json are in out"
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["outcome"], summary["failure"]) == ("failed", line)
    with Recording(tmp_path / "out" / RunFolder.LOG) as log:
        assert log.truncated is None
        assert log.count("c.twist") == {"reset": 0, "step": 3}.get(method, 11)
    assert not (tmp_path / "out" / "progress").exists()


def test_a_thread_that_a_stage_leaves_running_is_named_and_not_waited_for(tmp_path: Path) -> None:
    done = command(tmp_path, faulty("thread", "step"), "--no-pictures", program=GRAPHNAV)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("out: run.lcmlog") == 1
    assert done.stderr == "ended with threads that a plugin left running: lost\\x1b[2J\n"


@pytest.mark.parametrize("words", ["0", "-1", "nan", "soon", "1e10"])
def test_a_stall_limit_that_is_not_one_is_refused(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main([*WORDS, f"--stall-s={words}"])
    assert f"'{words}' is not a number of seconds above 0" in capsys.readouterr().err


@pytest.mark.parametrize(("kind", "reader"), [("exit", "info"), ("fault", "figure")])
def test_readers_tell_which_stage_ended_the_process(
    tmp_path: Path, kind: str, reader: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("graphnav.watch")
    command(tmp_path, faulty(kind, "step"))
    main([reader, str(tmp_path / "out")])
    said = "the run did not finish: its process ended early; the last call was step of stage 'b' (odd.faulty) at 0.20 s"
    assert said in "".join(capsys.readouterr())


def test_a_run_that_finished_leaves_no_progress(
    tmp_path: Path, run: Callable[[str], tuple[Summary, Recording]]
) -> None:
    unfinished = pytest.importorskip("graphnav.watch.loginfo").unfinished
    run(graph_text("faulty"))
    assert unfinished(tmp_path / "run" / RunFolder.LOG) == ""
    assert not (tmp_path / "run" / "progress").exists()


@pytest.mark.parametrize("content", [b"", b"{}", b"[]\n" + bytes(16), b'{"a": 1}\n' + b"\xff" * 16, b"\xff" * 40])
def test_damaged_progress_is_not_read(
    tmp_path: Path, run: Callable[[str], tuple[Summary, Recording]], content: bytes
) -> None:
    unfinished = pytest.importorskip("graphnav.watch.loginfo").unfinished
    run(graph_text("faulty"))
    (tmp_path / "run" / "summary.json").unlink()
    (tmp_path / "run" / "progress").write_bytes(content)
    assert unfinished(tmp_path / "run" / RunFolder.LOG) == "the run did not finish: its process ended early"


def test_a_run_in_progress_says_so(tmp_path: Path, run: Callable[[str], tuple[Summary, Recording]]) -> None:
    unfinished = pytest.importorskip("graphnav.watch.loginfo").unfinished
    run(graph_text("faulty"))
    (tmp_path / "run" / "summary.json").unlink()
    with ProgressFile(tmp_path / "run", {"b": "odd.faulty"}) as progress:
        progress.mark("b", "step", 200_000)
        assert unfinished(tmp_path / "run" / RunFolder.LOG) == "the run has not finished: its process still runs"
        assert str(ProgressFile.last_call(tmp_path / "run")) == "step of stage 'b' (odd.faulty) at 0.20 s"


def test_a_stage_that_changes_what_it_is_given_changes_nothing_for_others(
    run: Callable[[str], tuple[Summary, Recording]],
) -> None:
    more = "".join(f"  {name}: {{use: odd.speed, in: {{twist: c.twist}}}}\n" for name in ("a", "z"))
    summary, _ = run(graph_text("meddler") + more)
    assert summary.failure == ""
    assert {name: score["speed"] for name, score in summary.scores.items() if "speed" in score} == {"a": 1.0, "z": 1.0}
