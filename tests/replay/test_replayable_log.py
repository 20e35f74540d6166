"""Commands that read a log make again what it leaves out, and read what a full log would hold."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import graphnav
from graphnav.core.catalog import Catalog
from graphnav.core.cli import main
from graphnav.core.record import LogWriter, Recording
from graphnav.core.runner.recording import full_log
from graphnav.replay import completed_log
from graphnav.watch.commands.listening import complete
from graphnav.watch.feed import Feed
from graphnav.watch.view import PageFeed
from graphnav.watch.view.content.state import state_of

BEFORE = "run/run.lcmlog does not hold its large messages: an earlier replay kept them in the cache\n"
MADE = "run/run.lcmlog does not hold its large messages: a replay recomputed them in "
Capture = pytest.CaptureFixture[str]
Caplog = pytest.LogCaptureFixture
Run = Callable[..., None]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> Run:
    """Return a function that records a short drive in a folder; what is made again is kept by this test alone."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def record(*words: str, folder: str = "run") -> None:
        assert main(["run", "approach", "--until", "1", "--no-tap", "--no-pictures", "-o", folder, *words]) == 0
        capsys.readouterr()

    return record


def cached() -> list[Path]:
    """Return the logs that were made."""
    return sorted(Path("cache/graphnav/logs").iterdir())


def test_it_is_the_default_and_is_completed_byte_for_byte(run: Run, caplog: Caplog) -> None:
    run()
    run("--record", "all", folder="full")
    with Recording("run/run.lcmlog") as recording:
        assert recording.graph["run"]["record"] == "replayable"
        assert recording.n_bytes < Path("full/run.lcmlog").stat().st_size / 5
    with graphnav.open_log("run"):
        assert [path.read_bytes() for path in cached()] == [Path("full/run.lcmlog").read_bytes()]
    assert [record.message.startswith(MADE) for record in caplog.records] == [True]


@pytest.mark.parametrize(
    "words",
    [
        ["figure", "RUN", "-o", "OUT"],
        ["export", "RUN", "--to", "csv", "-o", "OUT"],
        ["export", "RUN", "--to", "images", "--channel", "robot.image", "-o", "OUT"],
        ["spy", "RUN", "--once"],
        ["echo", "flow.flow", "RUN", "--jsonl"],
        ["bw", "flow.flow", "RUN"],
        ["hz", "RUN"],
    ],
    ids=lambda words: str(words[0]),
)
def test_a_command_reads_what_a_full_log_holds(run: Run, capsys: Capture, words: list[str]) -> None:
    said, files = [], []
    for option, folder in (("replayable", "run"), ("all", "full")):
        run("--record", option, folder=folder)
        assert main([{"RUN": folder, "OUT": f"{folder}-out"}.get(word, word) for word in words]) == 0
        told = capsys.readouterr()
        said.append(told.out.replace(folder, "run"))
        files.append({path.name: path.read_bytes() for path in Path(f"{folder}-out").rglob("*") if path.is_file()})
        assert told.err.startswith(MADE) == (option == "replayable")
        assert told.err.count("\n") <= 1
    assert said[0] == said[1]
    assert files[0] == files[1]


def test_the_page_of_view_gets_what_a_full_log_holds(run: Run) -> None:
    shown = []
    for option, folder in (("replayable", "run"), ("all", "full")):
        run("--record", option, folder=folder)
        feed = complete(Feed(folder), Catalog(), [])
        source = PageFeed(feed)
        assert source.log is not None
        newest = []
        for at_s in (0.35, 1.0):
            source.log.seek(at_s)
            channels = source.state.watch.channels.items()
            newest.append({name: one.newest and one.newest.data for name, one in channels})
        shown.append((state_of(source, None), newest))
        source.start()
        source.close()
    assert shown[0][0]["log"]["length_s"] == 1.0
    assert len(shown[0][1][1]["flow.flow"] or b"") > 100_000
    assert shown[0] == shown[1]


def test_all_files_of_a_log_are_listed(tmp_path: Path, capsys: Capture) -> None:
    folder = str(tmp_path / "run")
    words = ["--until", "1", "--no-tap", "--no-pictures", "--set", "run.record={rotate_s: 0.6}"]
    assert main(["run", "approach", *words, "-o", folder]) == 0
    listed = [word for word in capsys.readouterr().out.splitlines()[-1].split() if word.endswith(".lcmlog")]
    assert listed == ["run.lcmlog", "run.0001.lcmlog"]


def test_what_is_recorded_is_read_at_once(run: Run, capsys: Capture) -> None:
    run()
    for channel in ("guard.twist", "robot.image", "graphnav.about"):
        assert main(["echo", channel, "run", "-n", "1"]) == 0
    assert main(["info", "run"]) == 0
    assert main(["replay", "run"]) == 0
    assert capsys.readouterr().err == ""
    assert not Path("cache").exists()


def test_it_is_made_once_and_few_are_kept(run: Run, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    run()
    run("--seed", "8", folder="other")
    assert main(["hz", "run"]) == main(["hz", "run"]) == 0
    assert capsys.readouterr().err.endswith(BEFORE)
    (first,) = cached()
    monkeypatch.setattr(completed_log, "MAX_CACHE_BYTES", 1000)
    assert main(["hz", "other"]) == 0
    (second,) = cached()
    assert first != second
    assert main(["hz", "run"]) == 0
    assert MADE in capsys.readouterr().err


def test_without_a_cache_it_is_made_every_time(run: Run, caplog: Caplog) -> None:
    run()
    Path("cache").write_text("a file, where the folder would be")
    for _ in range(2):
        with graphnav.open_log("run") as log:
            assert len(list(log.messages("flow.flow"))) == 10
    assert [record.message.startswith(MADE) for record in caplog.records] == [True, True]


def test_a_run_draws_what_a_full_log_would_show(run: Run, tmp_path: Path) -> None:
    for option in ("replayable", "all"):
        words = ["run", "approach", "--until", "1", "--no-tap", "--record", option, "-o", option]
        assert main(words) == 0
    names = sorted(path.name for path in Path("all").iterdir())
    assert sorted(path.name for path in Path("replayable").iterdir()) == names
    for name in (name for name in names if name.endswith(".png")):
        assert Path("replayable", name).read_bytes() == Path("all", name).read_bytes()
    assert not (tmp_path / "cache" / "graphnav").exists(), "it draws from what it published"


def test_where_it_cannot_be_made_what_there_is_is_shown(run: Run, capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(PLUGIN)
    run("--plugin", "mine.py", "--set", "steer=mine.ahead")
    shutil.copy("run/run.lcmlog", "alone.lcmlog")
    assert main(["spy", "alone.lcmlog", "--once"]) == 0
    said = capsys.readouterr()
    assert "flow.flow" in said.out
    assert said.err == (
        "alone.lcmlog does not hold its large messages, and they cannot be recomputed: there is no family 'mine'\n"
        "  only what it holds is shown; 'graphnav replay' tells more\n"
    )


def test_a_plugin_that_was_changed_does_not_run(run: Run, capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(PLUGIN)
    run("--plugin", "mine.py", "--set", "steer=mine.ahead")
    Path("run/plugins/mine.py").write_text("raise SystemExit('it ran')\n")
    assert main(["spy", "run", "--once"]) == 0
    assert (
        "they cannot be recomputed: its plugins are Python code that is not trusted (mine.py)"
        in capsys.readouterr().err
    )


def test_what_does_not_come_out_as_recorded_is_not_shown(run: Run, capsys: Capture) -> None:
    run()
    with Recording("run/run.lcmlog") as recording:
        events = list(recording.events())
    with LogWriter("run/run.lcmlog") as log:
        for channel, utime, data in events:
            log.write(channel, utime, data[:-1] + b"!" if channel == "control.twist" else data)
    assert main(["spy", "run", "--once"]) == 0
    assert (
        "they cannot be recomputed: a replay does not come out equal here, on control.twist" in capsys.readouterr().err
    )
    assert not cached()


def test_a_full_cache_is_named_and_what_to_do(run: Run, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    run()

    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "writev", full)
    assert main(["spy", "run", "--once"]) == 0
    assert capsys.readouterr().err.endswith(
        f"cannot write into {Path('cache/graphnav/logs').resolve()}: No space left on device\n"
        "  only what it holds is shown; free space there, or name another cache folder by XDG_CACHE_HOME\n"
    )
    assert not cached()


def test_a_nearly_full_disk_is_not_filled(run: Run, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    run()
    monkeypatch.setattr(completed_log, "_MIN_FREE_BYTES", 1 << 60)
    assert main(["spy", "run", "--once"]) == 0
    assert "MiB would stay free\n  only what it holds is shown; free space there" in capsys.readouterr().err
    assert not cached()


def test_what_a_killed_process_left_is_removed(run: Run, capsys: Capture) -> None:
    run()
    folder = Path("cache/graphnav/logs")
    folder.mkdir(parents=True, mode=0o700)
    old, new = folder / ".old.1.1", folder / ".new.2.2"
    for path in (old, new):
        path.write_bytes(b"unfinished")
    os.utime(old, (0, 0))
    assert main(["hz", "run"]) == 0
    assert MADE in capsys.readouterr().err
    assert not old.exists()
    assert new.exists()


def test_a_run_in_a_folder_whose_name_is_not_utf_8_is_completed(run: Run, capsys: Capture) -> None:
    folder = os.fsdecode(b"run\xff")
    run(folder=folder)
    assert main(["hz", folder]) == 0
    assert "recomputed them in" in capsys.readouterr().err
    assert len(cached()) == 1


def test_another_version_of_graphnav_makes_it_again(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    run()
    assert main(["hz", "run"]) == 0
    monkeypatch.setattr(completed_log, "__version__", "0.0.1")
    assert main(["hz", "run"]) == 0
    assert len(cached()) == 2


def test_a_run_on_a_nearly_full_disk_says_what_its_pictures_lack(
    run: Run, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(full_log, "_MIN_FREE_BYTES", 1 << 60)
    run(folder="unused")
    assert main(["run", "approach", "--until", "0.3", "--no-tap", "-o", "run"]) == 0
    assert "the pictures show only what the log of run holds" in (said := capsys.readouterr().err)
    assert said.endswith("free space, then run: graphnav figure run\n")


def test_info_tells_it(run: Run, capsys: Capture) -> None:
    run()
    hint = "write the complete log: graphnav replay run -o full.lcmlog"
    assert main(["info", "run"]) == 0
    assert (
        f"its large messages are not recorded, a replay recomputes them; {hint}" in capsys.readouterr().out.splitlines()
    )
    assert main(["info", "run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["completion_hint"] == hint


def test_the_log_of_the_replay_leaves_nothing_out(run: Run, capsys: Capture) -> None:
    run()
    assert main(["replay", "run", "-o", "full.lcmlog"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "reproduced: robot.truth, by stepping robot with the recorded guard.twist" in said.out.splitlines()
    assert main(["figure", "full.lcmlog", "-o", "pictures"]) == 0
    assert capsys.readouterr().err == ""


def test_what_is_played_is_made_again_first(run: Run, capsys: Capture) -> None:
    run()
    assert main(["replay", "run", "--play", "flow.flow"]) == 0
    said = capsys.readouterr()
    assert said.err.startswith(MADE)
    assert "no differences" in said.out


PLUGIN = """
import numpy as np
from graphnav import Plane, Stage, Steering, hookimpl

V = np.array([0.0, 1.0])


class Ahead(Stage):
    \"\"\"Drives ahead.\"\"\"

    def step(self, plane: Plane) -> Steering:
        return Steering(V, V, V, theta_rad=0.0, eigenvalues=V)


@hookimpl
def graphnav_stages():
    return [Ahead]
"""
