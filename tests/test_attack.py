"""A short attack: spoiled files, hostile messages, signals and full disks do no harm."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from attack import COUNTS, DISKS, attack, disturb
from attacks.own_time import OwnTime
from attacks.spoiled_files import KINDS
from attacks.verdict import Outcome, faults

N_FILES = 12


@pytest.mark.parametrize("kind", KINDS)
def test_spoiled_files_do_no_harm(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert attack(kind, N_FILES, 0, None, by_command=False) == 0, capsys.readouterr().out
    assert not list(tmp_path.iterdir()), "an attack writes into folders of its own only"


@pytest.mark.parametrize("kind", COUNTS)
def test_disturbed_runs_come_to_no_harm(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        n_wrong = disturb(kind, None, 0, is_long=False)
    except OSError as error:
        assert kind == DISKS
        pytest.skip(str(error))
    assert n_wrong == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    ("outcome", "fault"),
    [
        (Outcome(None, "", 20.0, 100.0), "hangs"),
        (Outcome(0, "", 0.1, 100.0, "ValueError: no"), "lets out ValueError"),
        (Outcome(-11, "", 0.1, 100.0), "exit status -11"),
        (Outcome(1, " \n", 0.1, 100.0), "without a word"),
        (Outcome(1, "Traceback (most recent call last)\n", 0.1, 100.0), "traceback"),
        (Outcome(0, "\x1b[31mred", 0.1, 100.0), "a terminal obeys"),
        (Outcome(0, "a\u202eb", 0.1, 100.0), "a terminal obeys"),
        (Outcome(0, "fine", 11.0, 100.0), "takes 11 s"),
        (Outcome(0, "fine", 0.1, 700.0), "takes 700 MB"),
    ],
)
def test_harm_is_seen(outcome: Outcome, fault: str) -> None:
    assert fault in "; ".join(faults(outcome))


def test_a_check_has_less_time_and_memory() -> None:
    outcome = Outcome(0, "fine", 7.0, 400.0, cpu_s=6.5)
    assert faults(outcome) == []
    assert faults(outcome, of_check=True) == ["takes 6.5 s of processor time", "takes 400 MB"]


def test_what_does_harm_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("attack.faults", lambda _, **__: ["harm"])
    assert attack("graphs", 2, 7, tmp_path / "kept", by_command=False) == 2
    assert sorted(path.name for path in (tmp_path / "kept").iterdir()) == ["graphs-7-graph.yaml", "graphs-8-graph.yaml"]


def test_the_own_time_of_a_process_is_at_most_what_has_passed() -> None:
    begin_s = time.monotonic()
    of_this, of_none = OwnTime(os.getpid()), OwnTime(2**22 + 1)
    time.sleep(0.05)
    assert 0.0 <= of_this.elapsed_s() <= time.monotonic() - begin_s
    assert 0.05 <= of_none.elapsed_s() <= time.monotonic() - begin_s, "nothing is known of a process that has ended"
