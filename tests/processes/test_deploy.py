"""``graphnav deploy``: units and compose files, and what they refuse."""

from __future__ import annotations

import getpass
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from graphnav import UserError
from graphnav.core.cli import main
from graphnav.processes.service_units import WRITTEN, Service, compose_files, systemd_files

GRAPH = """
about: Pass  a clock
  on.
stages:
  clock: {use: steps.count, with: {n: 25, rate_hz: 10}}
"""
STAGES = Path(__file__).parent / "stages.py"
ODD = "50% of $HOME; a 'b' \\ \"c\""


def service(**changes: object) -> Service:
    """Return a service that names odd things."""
    values: dict[str, object] = {
        "name": "robot",
        "about": "Drive on.",
        "program": "/a b/bin/graphnav",
        "arguments": ["run", "/maps/x.yaml", "--set", f"robot.about={ODD}"],
        "environment": {"LCM_DEFAULT_URL": "udpm://239.255.76.67:7667?ttl=0"},
        "reads": [Path("/maps")],
        "works_in": Path("/home/robot/50%"),
        "user": "robot",
        "buffer_bytes": 2_097_152,
        "restart": "on-failure",
        "watchdog_s": 2.5,
    }
    return Service(**(values | changes))  # type: ignore[arg-type]


def deployed(folder: Path, *options: str) -> str:
    """Return what ``graphnav deploy`` writes of a clock, as the unit or as the compose file."""
    (folder / "graph.yaml").write_text(GRAPH)
    given = ("--plugin", str(STAGES), *options)
    assert main(["deploy", str(folder / "graph.yaml"), "--live", "-o", str(folder / "out"), *given]) == 0
    return (folder / "out" / ("compose.yaml" if "compose" in options else "graphnav-graph.service")).read_text()


def test_a_unit_runs_the_graph_as_it_was_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=0")
    options = ("--set", "clock.n=3", "--seed", "4", "--until", "5", "--record", "all", "--processes")
    unit = deployed(tmp_path, "--to", "systemd", "--restart", "always", "--watchdog-s", "3", *options)
    program = Path(sys.executable).with_name("graphnav")
    expected = f"{tmp_path}/graph.yaml --set clock.n=3 --plugin {STAGES} --seed 4 --until 5.0 --record all"
    assert f"\nExecStart={program} run {expected} --processes --live --no-pictures\n" in unit
    for line in (
        "Description=graphnav graph: Pass a clock on.",
        "Type=notify",
        "WatchdogSec=3",
        "Restart=always",
        f"User={getpass.getuser()}",
        f"WorkingDirectory={tmp_path}",
        "Environment=LCM_DEFAULT_URL=udpm://239.255.76.67:7667?ttl=0",
    ):
        assert f"\n{line}\n" in unit
    assert "rmem_max = 2097152\n" in (tmp_path / "out" / "90-graphnav-graph.conf").read_text()


def test_a_compose_file_runs_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    content = yaml.safe_load(deployed(tmp_path, "--to", "compose", "--name", "My Robot"))
    assert content["name"] == "graphnav-my-robot"
    one = content["services"]["my-robot"]
    assert one["command"][:3] == ["graphnav", "run", f"{tmp_path}/graph.yaml"]
    assert one["healthcheck"]["test"] == ["CMD", "graphnav", "top", "--once"]
    mounted = {volume["source"]: volume.get("read_only", False) for volume in one["volumes"]}
    assert mounted == {str(tmp_path): True, str(STAGES.parent): True, str(tmp_path / "here"): False}
    assert (tmp_path / "out" / "Dockerfile").read_text().startswith(WRITTEN)


def test_words_are_quoted_for_systemd() -> None:
    unit = systemd_files(service())["graphnav-robot.service"]
    value = r"50%% of $$HOME; a 'b' \\ \"c\""
    assert f'ExecStart="/a b/bin/graphnav" run /maps/x.yaml --set "robot.about={value}"\n' in unit
    assert "WorkingDirectory=/home/robot/50%%\n" in unit


def test_dollars_are_escaped_for_compose() -> None:
    content = yaml.safe_load(compose_files(service())["compose.yaml"])
    assert content["services"]["robot"]["command"][-1] == f"robot.about={ODD}".replace("$", "$$")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_accepts_the_unit(tmp_path: Path) -> None:
    changes = {"program": "/bin/true", "works_in": tmp_path, "user": "root"}
    for name, text in systemd_files(service(**changes)).items():
        (tmp_path / name).write_text(text)
    command = ["systemd-analyze", "verify", "--man=no", str(tmp_path / "graphnav-robot.service")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    "changes",
    [
        {"arguments": ["run", "a\nb.yaml"]},
        {"works_in": Path("/a\nExecStart=/bin/false")},
        {"works_in": Path("/ends in a space ")},
        {"works_in": Path("/a\\b")},
        {"user": "a\tb"},
    ],
)
def test_what_no_unit_can_hold_is_refused(changes: dict[str, object]) -> None:
    with pytest.raises(UserError, match="cannot stand in a unit"):
        systemd_files(service(**changes))


def test_only_its_own_files_are_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    deployed(tmp_path, "--to", "systemd")
    assert "WatchdogSec=9" in deployed(tmp_path, "--to", "systemd", "--watchdog-s", "9")
    unit = tmp_path / "out" / "graphnav-graph.service"
    unit.write_text("mine")
    given = ("deploy", "graph.yaml", "--plugin", str(STAGES), "--live", "--to", "systemd", "-o", "out")
    assert main(given) == 2
    assert "graphnav-graph.service exists, and is not of this command" in capsys.readouterr().err
    assert unit.read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "graph runs in lockstep: it ends by itself, and nothing has to keep it running"),
        (("--live", "--name", "ä!"), "cannot name a service"),
        (("--live", "-o", "graph.yaml"), "cannot write into graph.yaml: "),
        (("--live", "--watchdog-s", "0"), "'0' is not a number of seconds above 0"),
        (("--url", "udpm://239.255.76.67:7667"), "graph runs in lockstep"),
    ],
)
def test_what_cannot_be_deployed_is_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    options: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "graph.yaml").write_text(GRAPH)
    try:
        status: object = main(["deploy", "graph.yaml", "--plugin", str(STAGES), "--to", "systemd", *options])
    except SystemExit as ended:
        status = ended.code
    assert status == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "units").exists()
