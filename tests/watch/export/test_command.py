"""``graphnav export`` says what it wrote and what is wrong."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.record import LogWriter
from graphnav.watch.commands import export as command
from graphnav.watch.export import FORMATS


def test_the_help_lists_every_format() -> None:
    assert list(command.FORMATS) == list(FORMATS)


def test_what_was_written_is_said(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "new" / "twist.csv"
    assert main(["export", str(drive), "--to", "csv", "--channel", "control.twist", "-o", str(target)]) == 0
    said = capsys.readouterr()
    assert said.out == f"{target}: 20 messages of 1 channel, {target.stat().st_size / 1e3:.0f} kB\n"
    assert said.err == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["--channel", "control.twst"],
            "{log} has no channel 'control.twst'\n  did you mean 'control.twist'?\n",
        ),
        (
            ["--from", "3s", "--until", "1s"],
            "--from 3s is after --until 1s\n  swap the two, or omit one\n",
        ),
        (
            ["--from", "2.5s"],
            "--from 2.5s is after the end of the log\n  the log lasts 2.000 s: give a smaller value\n",
        ),
    ],
)
def test_a_selection_of_nothing_is_an_error(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert main(["export", str(drive), "--to", "csv", "-o", str(tmp_path / "t"), *words]) == 2
    assert capsys.readouterr().err == said.format(log=drive / "run.lcmlog")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("time", ["-1s", "nan", "inf", "1m", "", "s", "1e999"])
def test_a_time_has_its_form(tmp_path: Path, capsys: pytest.CaptureFixture[str], time: str) -> None:
    with pytest.raises(SystemExit) as end:
        main(["export", str(tmp_path), "--to", "csv", "-o", "x", f"--from={time}"])
    assert end.value.code == 2
    assert f"argument --from: '{time}' is not a time: write 12.3s or 2min" in capsys.readouterr().err


def test_an_empty_log_has_nothing_to_export(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    LogWriter(tmp_path / "log").close()
    assert main(["export", str(tmp_path / "log"), "--to", "csv", "-o", str(tmp_path / "t")]) == 2
    assert capsys.readouterr().err == f"{tmp_path / 'log'} holds no messages\n  name another log\n"


@pytest.mark.parametrize(
    ("kind", "package", "said"),
    [
        ("mcap", "foxglove", "foxglove-sdk\n  pip install 'foxglove-sdk>=0.25'\n"),
        ("rrd", "rerun", "rerun-sdk\n  pip install 'rerun-sdk>=0.30'\n"),
        ("parquet", "pyarrow", "pyarrow\n  pip install 'pyarrow>=17'\n"),
    ],
)
def test_a_missing_package_names_its_extra(drive: Path, tmp_path: Path, kind: str, package: str, said: str) -> None:
    code = f"""
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == {package!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Missing())
from graphnav.core.cli import main
sys.exit(main({["export", str(drive), "--to", kind, "-o", str(tmp_path / "out")]!r}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, f"this export needs {said}")
    assert list(tmp_path.iterdir()) == []


def test_the_python_door_takes_a_recording(drive: Path, tmp_path: Path) -> None:
    from graphnav.core.record import Recording
    from graphnav.watch.export import Selection, export_log

    times: list[float] = []
    with Recording(drive / "run.lcmlog") as recording:
        done = export_log(recording, "csv", tmp_path / "t", Selection(("robot.*",), until_s=0.5), on_time=times.append)
    assert done.losses == []
    assert done.contents.endswith(" of 7 channels, one file per channel")
    assert 0.0 <= min(times) <= max(times) <= 0.5
