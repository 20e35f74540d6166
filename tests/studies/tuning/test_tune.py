"""``graphnav tune``: the same budget for all, the best is found, nothing is run twice."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path
from typing import Any

import pytest

import graphnav
from graphnav import UserError
from graphnav.core.cli import main
from graphnav.studies.ablation.execution import LockedFolder
from graphnav.studies.tuning import tuning_run

from .conftest import WORDS


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "trials.csv").open(newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def test_it_finds_what_is_better_and_moves_the_ranking(aim: dict[str, Any]) -> None:
    tuned = graphnav.tune(**aim | {"trials": 40})
    near, default = tuned.run.best(tuned.run.tuning.rivals[0]), tuned.run.default(tuned.run.tuning.rivals[0])
    assert (before := default.mean("score.miss_m")) is not None
    assert (after := near.mean("score.miss_m")) is not None
    assert 2.0 <= before <= 2.1
    assert after < 0.3
    assert abs(tuned.best["aim.near"]["aim.gain"] - 3.0) < 0.3
    assert [rival.label for rival in tuned.run.ranking(tuned=False)] == ["aim.fixed", "aim.near"]
    assert tuned.ranking == ("aim.near", "aim.fixed")
    assert "Tuning moves the ranking: as they are aim.fixed, then aim.near" in (tuned.folder / "tuned.md").read_text()


def test_every_rival_gets_the_same_trials_in_the_same_worlds(aim: dict[str, Any]) -> None:
    Path("rivals.yaml").write_text(
        "graph: aim\nseeds: 0:3\nvary:\n  aimer:\n    coarse: {aim.mode: coarse}\n    fine: {aim.mode: fine}\n"
        "metrics: [score.miss_m]\n"
    )
    tuned = graphnav.tune("rivals.yaml", trials=7, plugins=aim["plugins"], jobs=1)
    found = [(row["rival"], int(row["trial"]), int(row["seed"])) for row in rows(tuned.folder)]
    assert found == [(rival, trial, seed) for rival in ("coarse", "fine") for trial in range(7) for seed in range(3)]
    assert {one.target for rival in tuned.run.tuning.rivals for one in rival.space} == {"aim.gain", "aim.steps"}


def test_a_study_keeps_its_number_of_worlds_and_may_have_no_reference(aim: dict[str, Any]) -> None:
    text = "graph: aim\nseeds: 0:3\nworlds: {aim: 2}\nvary: {aim: [aim.near, aim.fixed]}\nmetrics: [score.miss_m]\n"
    Path("rivals.yaml").write_text(text)
    tuned = graphnav.tune("rivals.yaml", trials=1, plugins=aim["plugins"], jobs=1)
    assert [(row["trial"], row["seed"]) for row in rows(tuned.folder)] == [("0", "0"), ("0", "1")] * 2
    assert "(n " not in (tuned.folder / "tuned.md").read_text()
    Path("rivals.yaml").write_text(text + "reference: aim.near\n")
    with pytest.raises(UserError, match=r"rivals.yaml:6:12: a tuning has no runs of a reference"):
        graphnav.tune("rivals.yaml", trials=1, plugins=aim["plugins"], jobs=1)


def test_the_first_trial_changes_nothing_and_is_kept_unless_one_is_better(aim: dict[str, Any]) -> None:
    tuned = graphnav.tune(**aim | {"trials": 6}, search=["aim.gain=90:100", "aim.steps=1:3", "aim.mode=coarse"])
    assert tuned.best == {"aim.near": {}, "aim.fixed": {}}
    assert "as it is" in (text := tuned.study.read_text())
    assert "aim.near tuned" not in text


def test_parameters_that_a_stage_refuses_are_a_result(aim: dict[str, Any]) -> None:
    tuned = graphnav.tune(**aim | {"trials": 12}, search=["aim.gain=2:4"])
    refused = [trial for trial in tuned.trials if trial.refused]
    assert refused
    assert all("too much of it" in trial.refused for trial in refused)
    assert all(trial.mean("score.miss_m") is None for trial in refused)
    assert not tuned.run.best(tuned.run.tuning.rivals[0]).refused


def test_processes_do_not_change_what_is_found(aim: dict[str, Any], tmp_path: Path) -> None:
    for jobs, folder in ((1, "one"), (3, "three")):
        graphnav.tune(**aim | {"jobs": jobs}, folder=folder)
    for name in ("trials.csv", "tuned.yaml"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "three" / name).read_bytes()


def test_a_tuning_is_resumed_as_it_would_have_gone_on(aim: dict[str, Any], tmp_path: Path) -> None:
    graphnav.tune(**aim | {"trials": 14}, folder="whole")
    graphnav.tune(**aim | {"trials": 3}, folder="parts")
    graphnav.tune(**aim | {"trials": 7}, folder="parts")
    made = {path: path.stat().st_mtime_ns for path in (tmp_path / "parts").rglob("summary.json")}
    graphnav.tune(**aim | {"trials": 14}, folder="parts")
    assert {path: path.stat().st_mtime_ns for path in made} == made
    assert (tmp_path / "whole" / "trials.csv").read_bytes() == (tmp_path / "parts" / "trials.csv").read_bytes()


def test_fewer_trials_than_were_asked_for_are_refused(aim: dict[str, Any], tmp_path: Path) -> None:
    graphnav.tune(**aim | {"trials": 7}, folder="out")
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir() if path.is_file()}
    with pytest.raises(UserError) as caught:
        graphnav.tune(**aim | {"trials": 3}, folder="out")
    assert "holds a tuning that was begun with 7 trials of each rival, and this asks for 3" in str(caught.value)
    assert "continue it with 7 trials or more, or choose another folder with -o" in str(caught.value)
    assert "remove" not in str(caught.value)
    assert {path: path.read_bytes() for path in before} == before


def test_an_interrupted_resume_keeps_the_files_of_more_trials(
    aim: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    graphnav.tune(**aim | {"trials": 12}, folder="out")
    names = ("trials.csv", "tuned.yaml", "tuned.md")
    before = {name: (tmp_path / "out" / name).read_bytes() for name in names}

    def stop(*args: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(tuning_run, "execute", stop)
        with pytest.raises(KeyboardInterrupt):
            graphnav.tune(**aim | {"trials": 20}, folder="out")
    assert {name: (tmp_path / "out" / name).read_bytes() for name in names} == before
    graphnav.tune(**aim | {"trials": 20}, folder="out")
    assert len(rows(tmp_path / "out")) == (20 + 1) * 3


def test_the_number_of_worlds_belongs_to_what_is_tuned(aim: dict[str, Any]) -> None:
    text = "graph: aim\nseeds: 0:3\nvary: {aim: [aim.near, aim.fixed]}\nmetrics: [score.miss_m]\n"
    Path("rivals.yaml").write_text(text + "worlds: {aim: 2}\n")
    graphnav.tune("rivals.yaml", trials=1, plugins=aim["plugins"], jobs=1, folder="out")
    Path("rivals.yaml").write_text(text)
    with pytest.raises(UserError, match="out holds another tuning: its 'worlds' differs"):
        graphnav.tune("rivals.yaml", trials=1, plugins=aim["plugins"], jobs=1, folder="out")


def test_a_tuning_whose_process_was_killed_is_resumed(aim: dict[str, Any], tmp_path: Path) -> None:
    graphnav.tune(**aim | {"trials": 2}, folder="out")
    left = tmp_path / "out" / ".scratch" / "tmp1"
    left.mkdir(parents=True)
    (left / "run.lcmlog").touch()
    assert len(graphnav.tune(**aim | {"trials": 3}, folder="out").trials) == 4
    assert not left.parent.exists()


def test_two_processes_do_not_work_in_one_folder(aim: dict[str, Any], tmp_path: Path) -> None:
    graphnav.tune(**aim | {"trials": 1}, folder="out")
    record = (tmp_path / "out" / "tuning.json").read_bytes()
    held = LockedFolder(tmp_path / "out", "tuning.json", "tuning", "graphnav tune")
    with held, pytest.raises(UserError, match="another 'graphnav tune' is at work in"):
        graphnav.tune(**aim | {"trials": 2}, folder="out")
    assert (tmp_path / "out" / "tuning.json").read_bytes() == record


def test_the_tuned_rivals_are_a_study(aim: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*WORDS, "--trials", "25", "-o", "tuned", "-j", "2"]) == 0
    out = capsys.readouterr().out
    assert "aim.near: 25 trials of aim.gain=0.25:4:log, aim.mode=coarse,fine, aim.steps=1:8" in out
    assert "not searched, because nothing says what they could be: aim.free" in out
    assert "aim.fixed: 1 trial of nothing" in out
    words = ["ablate", "tuned/tuned.yaml", "--plugin", "my_aims.py", "--seeds", "100:104", "-o", "judged", "-j", "1"]
    assert main(words) == 0
    with Path("judged/results.csv").open(newline="", encoding="utf-8") as lines:
        misses = {row["variant"]: float(row["score.miss_m"]) for row in csv.DictReader(lines)}
    assert set(misses) == {"aim.near as it is", "aim.near tuned", "aim.fixed as it is"}
    assert misses["aim.near tuned"] < misses["aim.fixed as it is"] < misses["aim.near as it is"]


def test_logs_of_trials_are_not_kept(aim: dict[str, Any]) -> None:
    tuned = graphnav.tune(**aim | {"trials": 2})
    assert list(tuned.folder.rglob("summary.json"))
    assert not list(tuned.folder.rglob("*.lcmlog"))
    assert not (tuned.folder / ".scratch").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--seeds", "999:1001"],
            "--seeds: seed 1000 is for reporting: what is tuned in a world cannot be judged in it",
        ),
        (["--metrics", "score.his"], "'score.his': stage 'score' has no metric 'his'"),
        (["--search", "aim.gian=1:2"], "no rival has the parameter 'aim.gian'\n  did you mean 'aim.gain'?"),
        (["--search", "aim.gain=2:1"], "the range ends at 1, where it begins or before"),
        (["--search", "aim.gain=0:1:log"], "a logarithmic range must begin above 0, not at 0"),
        (["--search", "aim.gain=a:b"], "'a' is not a number"),
        (["--search", "aim.steps=0.5:3"], "'steps' must be an integer, not 0.5\n  'steps' is an integer, >= 1"),
        (["--search", "aim.gain=50:200"], "'gain' is 200, but must be > 0 and <= 100"),
        (["--search", "aim.mode=fine,coarze"], "not the string 'coarze'\n  did you mean 'coarse'?"),
        (["--search", "aim.mode=fine,fine"], "a choice is written twice"),
        (["--search", "aim=1:2"], "this does not name a parameter and its values"),
        (["--search", "aim.gain=1:2", "--search", "aim.gain=1:3"], "'aim.gain' is searched twice"),
        (["--vary", "aim=aim.fixed"], "the rivals have no parameter that could be searched"),
        (["--vary", "aim.steps=1,2"], "the study varies 2 axes: aim, aim.steps"),
        (["--vary", "aim=aim.nera"], "family 'aim' has no stage 'nera'\n  did you mean 'near'?"),
    ],
)
def test_errors_say_where_what_and_what_to_do(
    aim: dict[str, Any], capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    replaces_rivals = words[0] == "--vary" and words[1].startswith("aim=")
    base = [*WORDS[:2], *WORDS[4:]] if replaces_rivals else WORDS
    assert main([*base, "--trials", "2", *words]) == 2
    assert message in capsys.readouterr().err
    assert not Path("tunings").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"metrics": []}, "no metric to tune for is named"),
        ({"seeds": None}, "no worlds to tune in are named"),
        ({"trials": 0}, "trials must be an integer of at least 1, not 0"),
        ({"trials": "many"}, "trials"),
        ({"search": "aim.gain=1:2"}, "search"),
    ],
)
def test_python_gets_the_same_errors(aim: dict[str, Any], change: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        graphnav.tune(**aim | change)


def test_a_trial_that_fails_in_some_worlds_is_not_the_best(aim: dict[str, Any]) -> None:
    vary = {"aim": ["aim.frail", "aim.fixed"]}
    tuned = graphnav.tune(**aim | {"vary": vary, "trials": 25, "metrics": ["score.miss_m"], "seeds": range(8)})
    frail = tuned.run.tuning.rivals[0]
    default, best = tuned.run.default(frail), tuned.run.best(frail)
    survivors = [trial for trial in tuned.run.of(frail) if 0 < trial.n_runs("score.miss_m") < 8]
    means = [trial.mean("score.miss_m") for trial in (*survivors, best)]
    assert survivors
    assert min(mean for mean in means if mean is not None) != means[-1], "the mean of the runs that did not fail leads"
    assert best.n_runs("score.miss_m") == default.n_runs("score.miss_m") == 8
    assert 1.5 < best.params["aim.gain"] <= 2.0
    failed = sum(len(trial.failures) for trial in tuned.run.of(frail))
    text = (tuned.folder / "tuned.md").read_text()
    assert f"- aim.frail: {failed} of 200 runs failed: stage 'aim' (aim.frail) failed: out of range" in text
    assert sum(row["failed"] != "" for row in rows(tuned.folder)) == failed


def test_a_tuning_whose_runs_all_fail_says_so(aim: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["tune", "aim", "--vary", "aim=aim.frail", "--plugin", "my_aims.py", "--seeds", "1,2", "--trials", "2"]
    more = ["--metrics", "score.hit,score.miss_m", "--set", "aim.gain=3", "-j", "1"]
    assert main([*words, *more]) == 1
    out = capsys.readouterr().out
    assert "Every run failed or lacks score.hit: nothing was tuned." in out
    assert "aim.frail: 4 of 4 runs failed: stage 'aim' (aim.frail) failed: out of range" in out


def test_a_range_has_the_type_of_its_parameter(aim: dict[str, Any]) -> None:
    tuned = graphnav.tune(**aim | {"trials": 8}, search=["aim.gain=1:3", "aim.steps=1:32:log"])
    tried = [trial.params for trial in tuned.run.of(tuned.run.tuning.rivals[0]) if trial.params]
    assert any(params["aim.gain"] % 1 for params in tried)
    assert all(type(params["aim.steps"]) is int for params in tried)
    assert not any(trial.refused for trial in tuned.trials)


@pytest.mark.parametrize("words", [["--set", "aim.gain=2"], ["--vary", "aim.gain=1,2"]])
def test_a_parameter_that_is_set_is_not_searched(
    aim: dict[str, Any], capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    rivals = [] if words[0] == "--vary" else ["--vary", "aim=aim.near"]
    common = ["tune", "aim", "--plugin", "my_aims.py", "--seeds", "0:2", "--metrics", "score.hit", "--trials", "2"]
    assert main([*common, *rivals, *words, "--search", "aim.gain=1:3"]) == 2
    err = capsys.readouterr().err
    assert f"--search aim.gain=1:3: 'aim.gain' is searched, but {words[0]} aim.gain" in err
    assert "keep one of the two" in err


def test_the_study_finds_its_graph_from_any_folder(
    aim: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    graphnav.tune(**aim | {"trials": 1}, folder="deep/tuned")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    judged = graphnav.ablate("../deep/tuned/tuned.yaml", plugins=["../my_aims.py"], seeds=[100], jobs=1)
    assert len(judged.runs) == 2


def test_a_folder_of_another_tuning_is_refused(aim: dict[str, Any], tmp_path: Path) -> None:
    graphnav.tune(**aim | {"trials": 2}, folder="out")
    with pytest.raises(UserError, match="out holds another tuning: its 'seeds' differs"):
        graphnav.tune(**aim | {"trials": 2, "seeds": range(4)}, folder="out")
    settings = json.loads((tmp_path / "out" / "tuning.json").read_text())
    assert settings["seeds"] == [0, 1, 2]
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").touch()
    with pytest.raises(UserError, match=r"full holds mine.txt, but no tuning \(tuning.json\)"):
        graphnav.tune(**aim | {"trials": 2}, folder="full")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_an_error(aim: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "locked").mkdir(mode=0o500)
    with pytest.raises(UserError, match="cannot work in"):
        graphnav.tune(**aim | {"trials": 2}, folder="locked")


def test_labels_are_not_markup(aim: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    Path("rivals.yaml").write_text(
        "graph: aim\nseeds: 0:1\nmetrics: [score.miss_m]\n"
        "vary:\n  mode:\n    as is [old]: {aim.mode: coarse}\n    'new <b> [/old]': {aim.mode: fine}\n"
    )
    assert main(["tune", "rivals.yaml", "--plugin", "my_aims.py", "--trials", "1", "-o", "out", "-j", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("as is [old] ") for line in lines)
    assert any(line.startswith("new <b> [/old] ") for line in lines)
    assert "| new &lt;b> [/old] |" in Path("out/tuned.md").read_text()


def test_many_runs_need_a_confirmation(aim: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*WORDS, "--trials", "400"]) == 2
    assert "1203 runs are pending, and cannot ask for confirmation: not a terminal" in capsys.readouterr().err


def test_without_optuna_it_says_what_to_install(
    aim: dict[str, Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from graphnav.studies.tuning import tuning

    monkeypatch.setattr(tuning, "_SAMPLER", "no-such-package-as-this")
    assert main([*WORDS, "--trials", "2"]) == 2
    assert "graphnav tune needs Optuna\n  pip install 'optuna>=4.0'" in capsys.readouterr().err
