"""Targets are complete or absent, and errors leave no other files behind."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from graphnav.core.cli import main
from graphnav.core.errors import GraphnavError
from graphnav.core.runner.recording.log_forecast import size_text
from graphnav.watch.export import FORMATS
from graphnav.watch.export.files import placed_file, placed_folder

DiskOf = Callable[[int], AbstractContextManager[None]]

KINDS = sorted(FORMATS)


def names(folder: Path) -> list[str]:
    """Return everything in a folder, hidden files too."""
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("kind", KINDS)
def test_a_full_disk_is_said_and_leaves_nothing(
    drive: Path, tmp_path: Path, disk_of: DiskOf, capfd: pytest.CaptureFixture[str], kind: str
) -> None:
    target = tmp_path / "out" / "target"
    (tmp_path / "out").mkdir()
    with disk_of(1000):
        assert main(["export", str(drive), "--to", kind, "-o", str(target)]) == 1
    said = capfd.readouterr().err
    assert str(target) in said
    assert "make room" in said
    assert "Traceback" not in said
    assert names(tmp_path / "out") == []


@pytest.mark.parametrize("kind", KINDS)
def test_what_exists_is_replaced_only_if_told(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    target = tmp_path / "target"
    words = ["export", str(drive), "--to", kind, "-o", str(target), "--until", "0.3s"]
    assert main(words) == 0
    capsys.readouterr()
    before = {p: p.stat().st_mtime_ns for p in [target, *(target.iterdir() if target.is_dir() else ())]}
    assert main(words) == 2
    assert capsys.readouterr().err == (
        f"{target} is not empty\n  add --force to write into it, or choose another folder with -o\n"
        if target.is_dir()
        else f"{target} exists\n  add --force to replace it, or choose another name with -o\n"
    )
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert main([*words, "--force"]) == 0
    assert names(tmp_path) == ["target"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_place_that_cannot_be_written_is_named(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    (tmp_path / "file").touch()
    target = tmp_path / "file" / "target"
    assert main(["export", str(drive), "--to", kind, "-o", str(target)]) == 2
    assert capsys.readouterr().err == f"cannot write {target}: Not a directory\n  choose another place with -o\n"


def test_tables_go_into_a_folder_and_other_formats_into_a_file(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    assert main(["export", str(drive), "--to", "csv", "-o", str(tmp_path / "file"), "--force"]) == 2
    assert capsys.readouterr().err.startswith(f"{tmp_path / 'file'} is a file\n  name a folder with -o")
    assert main(["export", str(drive), "--to", "mcap", "-o", str(tmp_path), "--force"]) == 2
    assert capsys.readouterr().err == f"{tmp_path} is a folder\n  name a file with -o\n"


def test_files_of_others_in_a_folder_stay(drive: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    words = ["--channel", "control.twist", "--channel", "steer.steering", "--force"]
    assert main(["export", str(drive), "--to", "csv", "-o", str(tmp_path), *words]) == 0
    assert names(tmp_path) == ["control.twist.csv", "mine.txt", "steer.steering.csv"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_what_is_broken_off_leaves_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    file, folder = tmp_path / "file", tmp_path / "folder"
    file.write_text("before")
    folder.mkdir()

    def write_half(aside: Path) -> None:
        aside.write_text("half")
        raise error

    with pytest.raises(error), placed_file(file, ".txt", source=tmp_path, force=True) as aside:
        write_half(aside)
    with pytest.raises(error), placed_folder(folder, source=tmp_path, force=True) as aside:
        write_half(aside / "a")
    assert names(tmp_path) == ["file", "folder"]
    assert file.read_text() == "before"
    assert names(folder) == []


def test_a_file_has_the_permissions_of_a_new_one(drive: Path, tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        words = ["export", str(drive), "--to", "csv", "--channel", "control.twist", "-o", str(tmp_path / "a.csv")]
        assert main(words) == 0
    finally:
        os.umask(mask)
    assert (tmp_path / "a.csv").stat().st_mode & 0o777 == 0o640


def test_an_error_of_the_disk_names_the_target(tmp_path: Path) -> None:
    with pytest.raises(GraphnavError, match=r"cannot write .*/a: No space left on device\n  make room"):  # noqa: SIM117
        with placed_file(tmp_path / "a", "", source=tmp_path, force=False):
            raise OSError(28, os.strerror(28))
    assert names(tmp_path) == []


@pytest.mark.parametrize("kind", KINDS)
def test_the_log_itself_is_never_replaced(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    log, link = tmp_path / "run.lcmlog", tmp_path / "link"
    shutil.copy(drive / "run.lcmlog", log)
    link.symlink_to(log)
    channel = "robot.image" if kind in ("mp4", "images") else "control.twist"
    refused = "is the log to export\n  choose another place with -o\n"
    folder = "is a file\n  name a folder with -o, or one channel with --channel\n"
    for target in (log, link):
        words = ["--to", kind, "-o", str(target), "--channel", channel, "--force"]
        assert main(["export", str(tmp_path), *words]) == 2
        said = f"{target} {folder if kind in ('images', 'rosbag2') else refused}"
        assert capsys.readouterr().err == said
    assert log.read_bytes() == (drive / "run.lcmlog").read_bytes()


def test_a_log_that_is_called_like_a_table_is_not_replaced_either(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "control.twist.csv"
    shutil.copy(drive / "run.lcmlog", log)
    assert main(["export", str(log), "--to", "csv", "-o", str(tmp_path), "--force"]) == 2
    assert capsys.readouterr().err == f"{log} is the log to export\n  choose another place with -o\n"
    assert names(tmp_path) == ["control.twist.csv"]
    assert log.read_bytes() == (drive / "run.lcmlog").read_bytes()


def test_the_size_is_that_of_what_was_written(drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine").write_bytes(bytes(10_000_000))
    words = ["--channel", "control.twist", "--channel", "steer.steering", "--force"]
    assert main(["export", str(drive), "--to", "csv", "-o", str(tmp_path), *words]) == 0
    n_bytes = sum(path.stat().st_size for path in tmp_path.glob("*.csv"))
    assert capsys.readouterr().out.endswith(f", {size_text(n_bytes)}\n")
