"""`graphnav.core.trust`: what is remembered, and what is not believed."""

from __future__ import annotations

import multiprocessing
import os
import pwd
from pathlib import Path

import pytest

from graphnav.core.run_folder import RunFolder
from graphnav.core.trust import Request, Trust, forget, is_trusted, remember_written, state_file, trusted_folders
from graphnav.develop.completion.index import cache_file
from graphnav.replay.completed_log import cache_folder


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the state file of a user who trusts nothing."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "graphnav" / "trust.json"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Return a run folder with a plugin, which is not trusted."""
    folder = tmp_path / "run"
    (folder / RunFolder.PLUGINS).mkdir(parents=True)
    (folder / RunFolder.PLUGINS / "mine.py").write_bytes(b"a")
    (folder / RunFolder.GRAPH).touch()
    (folder / RunFolder.LOG).touch()
    return folder


def request_of_run(run: Path, content: bytes = b"a") -> Request:
    return Request.of(run / RunFolder.GRAPH, {run / RunFolder.PLUGINS / "mine.py": content})


def test_a_folder_is_trusted_until_it_is_revoked(tmp_path: Path) -> None:
    request = Request(tmp_path, ())
    assert not Trust().allows(request)
    assert request.remember() == ""
    assert Trust().allows(request)
    assert not is_trusted(Request(tmp_path / "below", ()))
    assert not is_trusted(Request(tmp_path.parent, ()))
    assert trusted_folders() == (str(tmp_path),)
    assert forget(tmp_path) == ""
    assert not is_trusted(request)


def test_a_folder_whose_name_is_not_utf_8_is_remembered_with_the_others(tmp_path: Path) -> None:
    named = tmp_path / os.fsdecode(b"n\xff")
    assert Request(tmp_path, ()).remember() == Request(named, ()).remember() == ""
    assert trusted_folders() == (str(tmp_path), str(named))
    assert forget(named) == ""
    assert trusted_folders() == (str(tmp_path),)


def test_a_yes_is_asked_for_once_and_remembered(tmp_path: Path) -> None:
    asked: list[Request] = []

    def ask(request: Request) -> bool:
        asked.append(request)
        return request.folder == tmp_path

    yes, no = Request(tmp_path, (tmp_path / "a.py",)), Request(tmp_path / "other", ())
    trust = Trust(ask=ask)
    assert [trust.allows(request) for request in (yes, no, yes, no)] == [True, False, True, False]
    assert asked == [yes, no]
    assert Trust().allows(yes)
    assert not Trust().allows(no)


def test_what_the_user_names_is_not_asked_about(tmp_path: Path) -> None:
    assert Trust(runs_all=True).allows(Request(tmp_path, ()))
    assert trusted_folders() == ()


def test_a_run_is_known_by_its_plugins_wherever_it_is(run: Path, tmp_path: Path) -> None:
    assert not is_trusted(request_of_run(run))
    remember_written({f"{RunFolder.PLUGINS}/mine.py": b"a"})
    assert is_trusted(request_of_run(run))
    run.rename(tmp_path / "moved")
    assert is_trusted(request_of_run(tmp_path / "moved"))


@pytest.mark.parametrize("name", ["numpy.py", "more/numpy.py", "__pycache__/mine.cpython-311.pyc"])
def test_a_file_that_is_added_to_a_run_makes_it_unknown(run: Path, name: str) -> None:
    remember_written({f"{RunFolder.PLUGINS}/mine.py": b"a"})
    (run / RunFolder.PLUGINS / name).parent.mkdir(exist_ok=True)
    (run / RunFolder.PLUGINS / name).write_bytes(b"a")
    assert not is_trusted(request_of_run(run))


def test_a_link_that_is_added_to_a_run_makes_it_unknown(run: Path) -> None:
    remember_written({f"{RunFolder.PLUGINS}/mine.py": b"a"})
    (run / RunFolder.PLUGINS / "package").symlink_to("/usr")
    assert not is_trusted(request_of_run(run))


def test_the_bytes_that_will_run_count_not_those_of_the_file(run: Path) -> None:
    remember_written({f"{RunFolder.PLUGINS}/mine.py": b"a"})
    assert not is_trusted(request_of_run(run, b"b"))


def test_trust_in_the_folder_of_a_run_is_not_trust_in_its_files(run: Path) -> None:
    Request(run, ()).remember()
    assert not is_trusted(request_of_run(run))


def test_a_plan_is_known_by_the_paths_and_contents_of_its_plugins(tmp_path: Path) -> None:
    files = {tmp_path / "mine.py": b"a"}
    Request.of_plan(tmp_path, files).remember()
    assert is_trusted(Request.of_plan(tmp_path / "moved", files))
    assert not is_trusted(Request.of_plan(tmp_path, {tmp_path / "mine.py": b"b"}))
    assert not is_trusted(Request.of_plan(tmp_path, {tmp_path / "other" / "mine.py": b"a"}))


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"folders": 3}', b'{"folders": [3, null]}', b"\xff" * 9])
def test_a_damaged_file_is_no_trust_and_is_replaced(tmp_path: Path, state: Path, content: bytes) -> None:
    state.parent.mkdir(parents=True)
    state.write_bytes(content)
    state.chmod(0o600)
    assert not is_trusted(Request(tmp_path, ()))
    assert Request(tmp_path, ()).remember() == ""
    assert is_trusted(Request(tmp_path, ()))


def test_what_others_may_write_is_not_believed(tmp_path: Path, state: Path) -> None:
    Request(tmp_path, ()).remember()
    assert (state.stat().st_mode & 0o777, state.parent.stat().st_mode & 0o777) == (0o600, 0o700)
    state.chmod(0o620)
    assert not is_trusted(Request(tmp_path, ()))
    state.chmod(0o600)
    state.parent.chmod(0o777)
    assert not is_trusted(Request(tmp_path, ()))
    assert Request(tmp_path, ()).remember() == f"others may write into {state.parent}"


def test_where_nothing_can_be_written_the_reason_is_told(
    tmp_path: Path, state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    state.parent.parent.mkdir()
    state.parent.write_text("a file where the folder should be")
    assert Request(tmp_path, ()).remember().startswith(f"cannot write {state}: ")
    assert Trust(ask=lambda _: True).allows(Request(tmp_path, ()))
    assert capsys.readouterr().err.startswith("this answer is not remembered: cannot write ")
    remember_written({"a": b""})


def test_the_file_is_where_xdg_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for given in ("", "relative"):
        monkeypatch.setenv("XDG_STATE_HOME", given)
        assert state_file() == tmp_path / ".local" / "state" / "graphnav" / "trust.json"
    monkeypatch.delenv("XDG_STATE_HOME")
    assert state_file() == tmp_path / ".local" / "state" / "graphnav" / "trust.json"


@pytest.mark.parametrize("home", ["", "relative", None])
def test_without_a_usable_home_the_password_database_says_where(
    home: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.delenv("XDG_CACHE_HOME")
    if home is None:
        monkeypatch.delenv("HOME")
    else:
        monkeypatch.setenv("HOME", home)
    entry = Path(pwd.getpwuid(os.getuid()).pw_dir)
    assert state_file() == entry / ".local" / "state" / "graphnav" / "trust.json"
    assert cache_folder() == entry / ".cache" / "graphnav" / "logs"
    assert cache_file() == entry / ".cache" / "graphnav" / "completion.json"


def test_a_user_without_an_entry_has_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "")
    monkeypatch.setattr(os, "getuid", lambda: 2**31 - 2)
    assert state_file() is cache_folder() is cache_file() is None
    assert Request(Path("/x"), ()).remember() == (
        "this user has no home folder: set XDG_STATE_HOME to an absolute path"
    )


def test_written_folders_are_bounded_and_the_newest_are_kept(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphnav.core.trust._MAX_DIGESTS", 3)
    for content in (b"a", b"b", b"c", b"d"):
        remember_written({f"{RunFolder.PLUGINS}/mine.py": content})
    (run / RunFolder.PLUGINS / "mine.py").write_bytes(b"d")
    assert [is_trusted(request_of_run(run, content)) for content in (b"a", b"b", b"d")] == [False, True, True]


def _remember_some(first: int) -> None:
    for number in range(first, first + 10):
        assert Request(Path(f"/folder/{number}"), ()).remember() == ""


def test_two_processes_lose_nothing_of_each_other() -> None:
    both = [multiprocessing.Process(target=_remember_some, args=(first,)) for first in (0, 10)]
    for process in both:
        process.start()
    for process in both:
        process.join(60)
        assert process.exitcode == 0
    assert len(trusted_folders()) == 20
