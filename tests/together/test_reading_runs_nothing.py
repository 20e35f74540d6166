"""Commands that read, check or draw run no plugin file that is not trusted; those that run do.

``tests/slow/test_trust.py`` tries every command; here are those that load graphs, in this process.
"""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import graphnav
from graphnav.core.cli import main
from graphnav.core.errors import UserError
from graphnav.core.record import Recording
from graphnav.replay.completed_log import cache_folder

PLUGIN = """
from pathlib import Path

import numpy as np

from graphnav import Flow, Image, Metric, Source, Stage, Twist, hookimpl, param

with Path({marker!r}).open("a") as file:
    file.write("ran\\n")


class Camera(Source):
    def step(self) -> Image:
        return Image(pixels=np.zeros((24, 32, 3), np.uint8))


class Painter(Stage):
    shade = 10

    def step(self, flow: Flow) -> Image:
        self.n_painted = getattr(self, "n_painted", 0) + 1
        return Image(pixels=np.full((48, 96), self.shade if self.n_painted > 1 else 0, np.uint8))


class Wheels(Stage):
    metrics = (Metric("way_m", unit="m", better="higher", help="The way."),)
    speed_mps: float = param(0.1, doc="the speed")

    def step(self, flow: Flow) -> Twist:
        return Twist(v_mps=self.speed_mps, omega_radps=0.0)

    def summary(self) -> dict[str, float]:
        return {{"way_m": self.speed_mps}}


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return [Camera, Painter, Wheels]
"""
GRAPH = """\
plugins: [mine.py]
run: {until_s: 2}
stages:
  camera: {use: mine.camera}
  flow: {use: flow.lucas_kanade, in: {image: camera.image}}
  painter: {use: mine.painter, in: {flow: flow.flow}}
  wheels: {use: mine.wheels, with: {speed_mps: 0.2}, in: {flow: flow.flow}}
"""
QUIET = ("--no-tap", "--no-pictures")
LEFT_OUT = (
    "theirs/graph.yaml:1:11: left out: plugin mine.py, Python code that is not trusted in theirs\n"
    "  run it with --trust, or trust the folder: graphnav trust theirs\n"
)

HasRun = Callable[[], bool]


@pytest.fixture
def has_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> HasRun:
    """Make ``theirs``, a folder with a graph and a plugin; return what tells whether it ran since the last call."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    marker = tmp_path / "marker"
    Path("theirs").mkdir()
    Path("theirs/mine.py").write_text(PLUGIN.format(marker=str(marker)))
    Path("theirs/graph.yaml").write_text(GRAPH)

    def asked() -> bool:
        found = marker.exists()
        marker.unlink(missing_ok=True)
        return found

    return asked


def run_theirs(has_run: HasRun, folder: str) -> None:
    """Run the graph, which records its plugin as known."""
    assert main(["run", "theirs/graph.yaml", *QUIET, "-o", folder]) == 0
    assert has_run()


def test_check_says_what_it_leaves_out_and_checks_the_rest(has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "theirs/graph.yaml"]) == 1
    said = capsys.readouterr()
    assert said.err == LEFT_OUT
    assert [" ".join(line.split()) for line in said.out.splitlines() if "." in line] == [
        "camera mine.camera camera.image: ?",
        "flow flow.lucas_kanade camera.image flow.flow: Flow",
        "flow.deviation: FlowDeviation",
        "painter mine.painter flow.flow",
        "wheels mine.wheels flow.flow",
        "graph.yaml is fine, except what was left out (camera, painter, wheels): 0 sources, 4 other stages, 2 channels",
    ]
    Path("theirs/graph.yaml").write_text("plugins: [mine.py]\nextends: approach\n")
    assert main(["check", "theirs/graph.yaml"]) == 1
    assert "is fine, except what was left out: 1 source," in capsys.readouterr().out
    Path("theirs/graph.yaml").write_text(
        GRAPH.replace("image: camera", "imag: camera").replace("until_s: 2", "unti: 2")
    )
    assert main(["check", "theirs/graph.yaml"]) == 2
    whats = [line.partition(": ")[2] for line in capsys.readouterr().err.splitlines() if line.startswith("theirs")]
    assert whats == [
        "left out: plugin mine.py, Python code that is not trusted in theirs",
        "run has no key 'unti'",
        "flow.lucas_kanade has no input 'imag'",
    ]
    assert not has_run()


def test_draw_shows_stages_that_it_does_not_know(has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["draw", "theirs/graph.yaml"]) == 0
    said = capsys.readouterr()
    assert said.err == LEFT_OUT
    for line in ("camera mine.camera", "▸ image: ?", "◂ image", "▸ flow: Flow", "wheels mine.wheels", "◂ flow"):
        assert line in " ".join(said.out.split())
    for kind in ("svg", "mermaid", "dot"):
        assert main(["draw", "theirs/graph.yaml", "--format", kind]) == 0
        assert "mine.wheels" in capsys.readouterr().out
    assert not has_run()


def test_a_loop_through_stages_that_are_not_known_is_drawn(has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    looped = "  camera: {use: mine.camera, in: {command: wheels.twist}}\n  again: {use: mine.x, in: {a: camera}}\n"
    Path("theirs/graph.yaml").write_text(GRAPH.replace("  camera: {use: mine.camera}\n", looped))
    for kind in ("text", "svg"):
        assert main(["draw", "theirs/graph.yaml", "--format", kind]) == 0
        assert "mine.wheels" in capsys.readouterr().out
    assert main(["check", "theirs/graph.yaml"]) == 1
    assert not has_run()


@pytest.mark.parametrize("words", [["profile"], ["check", "--resolved"], ["draw", "--set", "wheels.speed_mps=1"]])
def test_what_would_have_to_run_is_refused(
    words: list[str], has_run: HasRun, capsys: pytest.CaptureFixture[str]
) -> None:
    status = main([words[0], "theirs/graph.yaml", *words[1:]])
    assert status == (0 if words[0] == "draw" else 2)
    assert capsys.readouterr().err == LEFT_OUT
    assert not has_run()


@pytest.mark.parametrize("words", [["check"], ["draw"], ["check", "--resolved"], ["profile", "--json"]])
def test_trust_is_an_option_or_a_folder(words: list[str], has_run: HasRun) -> None:
    line = [words[0], "theirs/graph.yaml", *words[1:]]
    assert main([*line, "--trust"]) == 0
    assert has_run()
    assert main(line) != (0 if words[0] != "draw" else 1)
    assert not has_run(), "the option is not remembered"
    assert main(["trust", "theirs"]) == 0
    assert main(line) == 0
    assert has_run()
    assert main(["trust", "theirs", "--revoke"]) == 0
    main(line)
    assert not has_run()


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("answer", "is_yes"), [("y\n", True), ("YES\n", True), ("\n", False), ("", False)])
def test_at_a_terminal_the_user_is_asked_once(
    answer: str, is_yes: bool, has_run: HasRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in (1, 2):
        shown = _Terminal()
        monkeypatch.setattr("sys.stdin", _Terminal(answer if number == 1 else "n\n"))
        monkeypatch.setattr("sys.stderr", shown)
        assert main(["check", "theirs/graph.yaml"]) == (0 if is_yes else 1)
        assert has_run() == is_yes
        is_asked = number == 1 or not is_yes
        assert shown.getvalue().startswith("theirs brings Python code") == is_asked
        assert ("theirs/mine.py\n" in shown.getvalue()) == is_asked


def test_names_that_would_act_on_the_terminal_are_text(has_run: HasRun, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("theirs/mine.py").rename("theirs/\x1b[2Jmine.py")
    Path("theirs/graph.yaml").write_text(GRAPH.replace("mine.py", '"\\e[2Jmine.py"'))
    shown = _Terminal()
    monkeypatch.setattr("sys.stdin", _Terminal("n\n"))
    monkeypatch.setattr("sys.stderr", shown)
    assert main(["check", "theirs/graph.yaml"]) == 1
    assert "\x1b" not in shown.getvalue()
    assert "\\x1b[2Jmine.py" in shown.getvalue()
    assert not has_run()


def test_a_run_of_ones_own_replays_without_asking(has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    run_theirs(has_run, "run")
    shutil.move("run", "moved")
    shutil.rmtree("theirs")
    for words in (["replay", "moved"], ["check", "moved/graph.yaml"], ["draw", "moved/graph.yaml"]):
        assert main(words) == 0
        assert has_run()
    assert "left out" not in capsys.readouterr().err


READERS = {
    "figure": ["figure", "run", "-o", "out"],
    "export": ["export", "run", "--to", "csv", "-o", "out"],
    "spy": ["spy", "run", "--once"],
    "echo": ["echo", "painter.image", "run", "--jsonl"],
    "hz": ["hz", "run"],
    "bw": ["bw", "painter.image", "run"],
    "play": ["play", "run", "--speed", "1000"],
}
"""Commands that make again what the log of a run leaves out, and then read it."""
NOT_MADE = (
    "run/run.lcmlog does not hold its large messages, and they cannot be recomputed: its plugins are Python code "
    "that is not trusted (mine.py)\n  only what it holds is shown; run it with --trust\n"
)
MADE = "run/run.lcmlog does not hold its large messages: a"


@pytest.fixture
def run(has_run: HasRun) -> Path:
    """Return the folder of a run of the user's own, whose log lacks large messages."""
    run_theirs(has_run, "run")
    with Recording("run/run.lcmlog") as recording:
        assert recording.lacks("painter.image")
    return Path("run")


def changed(run: Path) -> None:
    """Make the run one that comes from elsewhere."""
    plugin = run / "plugins" / "mine.py"
    plugin.write_text(plugin.read_text() + "# changed\n")


@pytest.mark.parametrize("name", READERS)
def test_the_log_of_a_run_that_was_changed_is_not_completed(
    name: str, run: Path, has_run: HasRun, capsys: pytest.CaptureFixture[str], group: str
) -> None:
    changed(run)
    assert main(READERS[name]) == 0
    said = capsys.readouterr()
    assert said.out != ""
    assert said.err == NOT_MADE
    assert not has_run()
    assert main([*READERS[name], "--trust", *(["--force"] if name == "export" else [])]) == 0
    assert capsys.readouterr().err.startswith(MADE)
    assert has_run()


def test_the_log_of_ones_own_run_is_completed_without_asking(
    run: Path, has_run: HasRun, monkeypatch: pytest.MonkeyPatch, group: str
) -> None:
    for words in (words for name, words in READERS.items() if name != "figure"):
        shown = _Terminal()
        monkeypatch.setattr("sys.stdin", _Terminal("n\n"))
        monkeypatch.setattr("sys.stderr", shown)
        assert main(words) == 0
        assert MADE in shown.getvalue()
        assert "trusted" not in shown.getvalue()
        assert has_run()
        folder = cache_folder()
        assert folder is not None
        shutil.rmtree(folder)


def test_a_page_of_a_run_that_was_changed_shows_what_is_recorded(
    run: Path, has_run: HasRun, capsys: pytest.CaptureFixture[str]
) -> None:
    changed(run)
    with server() as (port, _):
        for words, notice, may in (([], NOT_MADE, False), (["--trust"], MADE, True)):
            assert main(["view", "run", "--port", str(port), *words]) == 2
            said = capsys.readouterr().err
            assert said.startswith(notice)
            assert f"cannot listen on 127.0.0.1, port {port}" in said
            assert has_run() == may


@pytest.mark.parametrize(("answer", "is_yes"), [("y\n", True), ("n\n", False)])
def test_at_a_terminal_the_user_is_asked_whether_a_log_is_completed(
    answer: str, is_yes: bool, run: Path, has_run: HasRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed(run)
    for channel, is_asked in (("wheels.twist", False), ("painter.image", True)):
        shown = _Terminal()
        monkeypatch.setattr("sys.stdin", _Terminal(answer))
        monkeypatch.setattr("sys.stderr", shown)
        assert main(["echo", channel, "run"]) == 0
        assert shown.getvalue().startswith("run brings Python code") == is_asked
        assert has_run() == (is_asked and is_yes)
    assert (MADE if is_yes else NOT_MADE) in shown.getvalue()


def test_what_others_plugins_made_is_not_shown_of_ones_own_run(run: Path, has_run: HasRun) -> None:
    plugin = run / "plugins" / "mine.py"
    own = plugin.read_text()
    shades = []
    for text in (own.replace("shade = 10", "shade = 66"), own):
        plugin.write_text(text)
        with graphnav.open_log("run", trust=text != own) as log:
            shades.append(log.stack("painter.image", "pixels").values[-1, 0, 0])
        assert has_run()
    assert shades == [66, 10]
    shutil.copytree("run", "copy")
    (Path("copy") / "plugins" / "mine.py").write_text(own.replace("shade = 10", "shade = 66"))
    with graphnav.open_log("copy") as log:
        assert log.stack("painter.image", "pixels").values.shape[0] == 1, "only the recorded one"
    assert not has_run()


def test_a_cache_that_others_may_write_is_not_read(
    run: Path, has_run: HasRun, caplog: pytest.LogCaptureFixture
) -> None:
    folder = cache_folder()
    assert folder is not None
    folder.mkdir(parents=True, exist_ok=True)
    for mode, told in ((0o700, "a replay recomputed"), (0o700, "an earlier replay"), (0o770, "a replay recomputed")):
        folder.chmod(mode)
        caplog.clear()
        with graphnav.open_log("run"):
            assert told in caplog.text
    folder.chmod(0o700)


@pytest.mark.parametrize("change", ["edit", "add", "bytecode"])
def test_a_run_that_was_changed_does_not_run(change: str, has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    run_theirs(has_run, "run")
    plugin = Path("run/plugins/mine.py")
    if change == "edit":
        plugin.write_text(plugin.read_text() + "# changed\n")
    elif change == "add":
        shutil.copy(plugin, "run/plugins/numpy.py")
    else:
        plugin.with_name("__pycache__").mkdir()
        plugin.with_name("__pycache__").joinpath("mine.cpython-311.pyc").write_bytes(b"")
    for words in (
        ["replay", "run"],
        ["check", "run/graph.yaml"],
        ["draw", "run/graph.yaml"],
        ["profile", "run/graph.yaml"],
    ):
        main(words)
        assert "left out: plugin plugins/mine.py, Python code that is not trusted in run\n" in capsys.readouterr().err
    assert not has_run()
    assert main(["replay", "run", "--trust"]) == 0
    assert has_run()


def test_a_compiled_file_beside_a_plugin_is_not_used(has_run: HasRun) -> None:
    import importlib.util
    import os
    import py_compile

    source = Path("theirs/mine.py")
    good, at = source.read_text(), source.stat()
    source.write_text("raise SystemExit('compiled elsewhere')".ljust(len(good)))
    py_compile.compile(str(source), importlib.util.cache_from_source(str(source)))
    source.write_text(good)
    os.utime(source, ns=(at.st_atime_ns, at.st_mtime_ns))
    compiled = Path(importlib.util.cache_from_source(str(source)))
    data = bytearray(compiled.read_bytes())
    data[8:16] = int(at.st_mtime).to_bytes(4, "little") + len(good).to_bytes(4, "little")
    compiled.write_bytes(data)
    assert main(["check", "theirs/graph.yaml", "--trust"]) == 0
    assert has_run()


def test_the_report_of_a_study_runs_no_file_that_its_plan_names(
    has_run: HasRun, capsys: pytest.CaptureFixture[str]
) -> None:
    study = ["ablate", "theirs/graph.yaml", "--vary", "wheels.speed_mps=0.1,0.2", "--seeds", "0:1", "-o", "study"]
    assert main([*study, "-j", "1", "--gallery", "0"]) == 0
    assert has_run()
    assert main(["ablate", "--report", "study"]) == 0
    assert has_run(), "the study is this user's"
    plan = json.loads(Path("study/plan.json").read_text())
    foreign = Path("foreign.py").resolve()
    foreign.write_text(Path("theirs/mine.py").read_text())
    plan["plugins"] = [str(foreign)]
    Path("study/plan.json").write_text(json.dumps(plan))
    capsys.readouterr()
    Path("study/report.html").unlink()
    assert main(["ablate", "--report", "study"]) == 0
    assert not has_run()
    left_out = f"left out: plugin {foreign}, Python code that is not trusted\n  run it with --trust\n"
    assert capsys.readouterr().err == left_out
    assert Path("study/report.html").is_file()
    assert main(["ablate", "--report", "study", "--trust"]) == 0
    assert has_run()


@pytest.mark.parametrize("command", ["check", "draw", "doctor", "profile", "run", "ablate", "tune", "teach"])
@pytest.mark.parametrize("way", ["relative", "absolute", "link", "home"])
def test_a_plugin_stays_below_the_folder_of_its_graph(
    command: str, way: str, has_run: HasRun, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(Path("theirs").resolve()))
    Path("other").mkdir()
    names = {"relative": "../theirs/mine.py", "absolute": str(Path("theirs/mine.py").resolve())}
    names |= {"link": "mine.py", "home": "~/mine.py"}
    if way == "link":
        Path("other/mine.py").symlink_to("../theirs/mine.py")
    Path("other/graph.yaml").write_text(
        GRAPH.replace("mine.py", names.get(way, "~/mine.py" if way == "home" else "mine.py"))
    )
    more = {"teach": ["-o", "out.lcmlog"], "run": QUIET, "ablate": ["--vary", "wheels.speed_mps=0,1", "--seeds", "0:1"]}
    more["tune"] = [*more["ablate"], "--metrics", "wheels.way_m", "--search", "wheels.speed_mps=0:1", "--trials", "2"]
    assert main([command, "other/graph.yaml", *more.get(command, ())]) == 2
    said = "file not found" if way == "home" else "is outside of the folder of its graph\n"
    assert said in capsys.readouterr().err
    assert not has_run()


def test_a_file_elsewhere_is_named_by_the_user(has_run: HasRun) -> None:
    Path("other").mkdir()
    Path("other/graph.yaml").write_text(GRAPH.replace("mine.py", "../theirs/mine.py"))
    assert main(["check", "other/graph.yaml", "--plugin", "theirs/mine.py"]) == 0
    assert has_run()


def test_a_replay_compares_all_of_the_graph_with_the_log(has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    run_theirs(has_run, "run")
    assert main(["replay", "run"]) == 0
    saved = Path("run/graph.yaml")
    good = saved.read_text()
    changes = {
        "run": ("until_s: 2", "until_s: 1"),
        "stages": ("speed_mps: 0.2", "speed_mps: 9"),
        "about": ("", "about: x\n"),
    }
    for section, (old, new) in changes.items():
        saved.write_text(good.replace(old, new, 1))
        assert saved.read_text() != good
        capsys.readouterr()
        assert main(["replay", "run", "--plugin", "theirs/mine.py"]) == 0, "what the log says is stepped"
        told = f"run/graph.yaml is not the graph of the log: '{section}' differs; that of the log is stepped\n"
        assert told in capsys.readouterr().err


@contextlib.contextmanager
def server() -> Iterator[tuple[int, list[int]]]:
    """Yield the port of a server and a list that grows with every connection to it."""
    heard: list[int] = []
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def accept() -> None:
            with contextlib.suppress(OSError):
                while True:
                    listening.accept()[0].close()
                    heard.append(1)

        thread = threading.Thread(target=accept)
        thread.start()
        yield listening.getsockname()[1], heard
        listening.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_only_a_run_opens_a_stream(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with server() as (port, heard):
        camera = f'{{use: io.video, with: {{path: "http://127.0.0.1:{port}/a.mp4?x=[1]", open_timeout_s: 0.5}}}}'
        Path("stream.yaml").write_text(f"run: {{until_s: 1}}\nstages: {{camera: {camera}}}\n")
        for words in (["check"], ["check", "--resolved"], ["draw"], ["doctor"]):
            assert main([words[0], "stream.yaml", *words[1:]]) in ({0, 1} if words == ["doctor"] else {0})
        assert graphnav.check("stream.yaml") == []
        assert heard == []
        assert main(["run", "stream.yaml", *QUIET, "-o", "out"]) == 1
        assert heard != []


def test_from_python_trust_is_an_argument(has_run: HasRun) -> None:
    for function in (graphnav.load, graphnav.draw, graphnav.profile):
        with pytest.raises(UserError) as caught:
            function("theirs/graph.yaml")
        assert [problem.kind for problem in caught.value.problems] == ["untrusted"]
        assert caught.value.problems[0].hint == "pass trust=True to run it"
    assert [problem.kind for problem in graphnav.check("theirs/graph.yaml")] == ["untrusted"]
    assert not has_run()
    assert graphnav.check("theirs/graph.yaml", trust=True) == []
    assert has_run()
    done = graphnav.run("theirs/graph.yaml", pictures=False, folder="run")
    assert done.outcome == "timeout"
    assert has_run()
    assert done.log.stack("painter.image", "pixels").values.shape[0] > 1, "it may make its own messages again"
    changed(Path("run"))
    for trust in (False, True):
        with graphnav.open_log("run", trust=trust) as log:
            assert (log.stack("painter.image", "pixels").values.shape[0] > 1) == trust


def test_the_command_lists_folders(has_run: HasRun, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trust"]) == 0
    assert capsys.readouterr() == ("", "")
    folder = Path("theirs").resolve()
    assert main(["trust", "theirs"]) == 0
    done = "plugin files that graphs in it name run without a question\n"
    assert capsys.readouterr().out == f"trusted: {folder}; {done}"
    assert main(["trust", "theirs"]) == 0
    assert capsys.readouterr().out == f"already trusted: {folder}; {done}"
    assert main(["trust"]) == 0
    assert capsys.readouterr().out == f"{Path('theirs').resolve()}\n"
    for words, said in (
        (["nowhere"], "nowhere is not a folder\n  name the folder of a graph\n"),
        ([".", "--revoke"], ". is not trusted\n  graphnav trust lists the folders that are\n"),
        (["--revoke"], "--revoke needs a folder\n  graphnav trust lists those that are trusted\n"),
    ):
        assert main(["trust", *words]) == 2
        assert capsys.readouterr().err == said
    assert not has_run()
