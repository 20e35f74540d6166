"""``graphnav info``: what a log holds, who made it, what is missing."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from graphnav.core.cli import main
from graphnav.core.codec import encode, lcm_text_of
from graphnav.core.messages import About, Flow, Twist
from graphnav.core.record import LogWriter

from .recording import GRAPHNAV

GRAPH = "about: Follow the floor.\nstages:\n  robot: {use: world.pymunk}\n  flow: {use: flow.lucas_kanade}\n"
SAID = About(
    GRAPH,
    lcm_text_of([Twist.lcm_class]),
    "",
    7,
    ("control.twist", "other"),
    ("graphnav_lcm.twist_t", "not_installed.thing_t"),
)
FLOW = Flow(uv_px=np.zeros((2, 3, 2), np.float32), valid=np.ones((2, 3), np.uint8), interval_us=100_000)
SUMMARY = {
    "graph": "corridor",
    "run_id": "cafe1234",
    "outcome": "goal",
    "versions": {"graphnav": "0.2.0", "lcm": "1.5.3"},
}


def write_run(folder: Path, begin_us: int = 0) -> Path:
    """Write what a run leaves: 21 flows and commands at 10 Hz, of which three commands are missing."""
    with LogWriter(folder / "run.lcmlog") as log:
        log.write(About.CHANNEL, begin_us, encode(SAID, 0, 0))
        for k in range(21):
            utime = begin_us + 100_000 * k
            log.write("flow.flow", utime, encode(FLOW, utime, k))
            if k not in {5, 6, 9}:
                log.write("control.twist", utime, encode(Twist(0.1, 0.2), utime, k))
        log.write("other", begin_us + 2_000_000, bytes(range(1, 9)))
        log.write("other", begin_us + 2_000_000, b"short")
    (folder / "summary.json").write_text(json.dumps(SUMMARY))
    return folder


def test_a_run_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(write_run(tmp_path))]) == 0
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    size = (tmp_path / "run.lcmlog").stat().st_size
    assert lines[:4] == [
        f"{tmp_path / 'run.lcmlog'}: {size / 1000:.0f} kB, 42 messages on 4 channels, 2.000 s",
        "simulated time from 0.000 s",
        "run of the graph corridor: 2 stages, seed 7, run cafe1234, outcome goal, graphnav 0.2.0, lcm 1.5.3",
        "  Follow the floor.",
    ]
    rows = {line.split()[0]: " ".join(line.split()[1:]) for line in lines[4:] if line.strip() and "─" not in line}
    assert rows["channel"] == "type messages rate size total lost"
    assert rows["control.twist"] == "twist_t 18 8.50 Hz 40 B 720 B 3"
    assert rows["flow.flow"] == "flow_t 21 10.00 Hz 98 B 2 kB 0"
    assert rows["other"] == "not_installed.thing_t (fingerprint 0102030405060708) 2 5 B to 8 B 13 B"
    assert lines[-1] == "other: 1 of 2 messages cannot be decoded as not_installed.thing_t"


def test_programs_are_told_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "--json", str(write_run(tmp_path) / "run.lcmlog")]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["made_by"] == {
        "name": "corridor",
        "about": "Follow the floor.",
        "seed": 7,
        "run_id": "cafe1234",
        "outcome": "goal",
        "n_stages": 2,
        "versions": SUMMARY["versions"],
    }
    assert (said["messages"], said["duration_s"], said["is_wall_time"]) == (42, 2.0, False)
    assert (said["damaged"], said["truncated"], said["stamp_jumps"]) == ([], None, 0)
    assert said["channels"]["control.twist"] == {
        "type": "graphnav_lcm.twist_t",
        "is_known": True,
        "fingerprint": encode(Twist(0, 0), 0, 0)[:8].hex(),
        "messages": 18,
        "rate_hz": pytest.approx(8.5),
        "first_s": 0.0,
        "last_s": 2.0,
        "bytes": 720,
        "min_bytes": 40,
        "max_bytes": 40,
        "lost": 3,
        "lost_since_restart": 3,
        "restarts": 0,
        "undecodable": 0,
    }
    assert said["channels"]["other"]["lost"] is None


def test_the_time_of_day_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(write_run(tmp_path, 1_700_000_000_250_000))]) == 0
    assert "begins 2023-11-14 22:13:20.250000 UTC\n" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", '{"graph": 3, "versions": 4, "seed": "x"}', "[" * 100_000])
def test_a_summary_that_cannot_be_read_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    write_run(tmp_path)
    (tmp_path / "summary.json").write_text(text)
    assert main(["info", str(tmp_path)]) == 0
    assert "run of a graph whose name is not recorded: 2 stages, seed 7\n" in capsys.readouterr().out


def test_a_part_of_a_run_names_its_graph(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_run(tmp_path)
    (tmp_path / "run.0001.lcmlog").write_bytes((tmp_path / "run.lcmlog").read_bytes())
    assert main(["info", str(tmp_path / "run.0001.lcmlog")]) == 0
    assert "run of the graph corridor: 2 stages, seed 7" in capsys.readouterr().out


def test_a_log_of_others_has_types_by_fingerprint(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("WHEELS", 5, encode(Twist(0.1, 0.2), 5, 6))
        log.write("WHEELS", 6, encode(Twist(0.1, 0.2), 5, 7)[:-1])
        log.write("OTHER", 7, bytes(40))
        log.write("TINY", 7, b"")
        log.write("FIRST_IS_DAMAGED", 7, bytes(40))
        log.write("FIRST_IS_DAMAGED", 8, encode(Twist(0.1, 0.2), 5, 6))
    assert main(["info", "--json", str(tmp_path / "log")]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["made_by"] is None
    found = {name: (one["type"], one["undecodable"]) for name, one in said["channels"].items()}
    assert found == {
        "WHEELS": ("graphnav_lcm.twist_t", 1),
        "OTHER": (None, 0),
        "TINY": (None, 0),
        "FIRST_IS_DAMAGED": ("graphnav_lcm.twist_t", 1),
    }
    assert main(["info", str(tmp_path / "log")]) == 0
    out = capsys.readouterr().out
    assert "unknown, fingerprint 0000000000000000" in out
    assert "not an LCM type" in out
    assert "WHEELS: 1 of 2 messages cannot be decoded as graphnav_lcm.twist_t\n" in out


def test_types_of_other_packages_are_decoded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In a process of its own: types that were made known stay known."""
    (tmp_path / "types").mkdir()
    (tmp_path / "types" / "gps_t.lcm").write_text(
        "package foreign;\nstruct gps_t { int64_t utime; int64_t seq; double x; }\n"
    )
    script = (
        "import sys\n"
        "from graphnav.core.codec import codec_of\n"
        "from graphnav.core.record import LogWriter\n"
        "from graphnav.core.typeinfo import load_types\n"
        "gps_t = load_types([sys.argv[1]])['foreign.gps_t']\n"
        "with LogWriter(sys.argv[2]) as log:\n"
        "    for k in (0, 1, 4):\n"
        "        log.write('GPS', k, codec_of(gps_t).encode({'utime': k, 'seq': k, 'x': 1.5}))\n"
    )
    log, types = str(tmp_path / "log"), str(tmp_path / "types")
    subprocess.run([sys.executable, "-c", script, types, log], check=True)
    assert main(["info", log]) == 0
    assert "unknown, fingerprint " in capsys.readouterr().out
    told = subprocess.run([GRAPHNAV, "info", log, "--types", types, "--json"], check=True, capture_output=True).stdout
    gps = json.loads(told)["channels"]["GPS"]
    assert (gps["type"], gps["messages"], gps["lost"], gps["undecodable"]) == ("foreign.gps_t", 3, 2, 0)


def test_damage_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = (write_run(tmp_path) / "run.lcmlog").read_bytes()
    places = [at for at in range(len(data)) if data[at : at + 4] == bytes.fromhex("eda1da01")]
    damaged = bytearray(data[:-3])
    damaged[places[10]] ^= 1
    damaged[places[20] + 12] ^= 0x40
    (tmp_path / "run.lcmlog").write_bytes(damaged)
    assert main(["info", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-3:] == [
        "1 timestamps jump: the clock was set, or they are damaged",
        f"{places[11] - places[10]} bytes from byte {places[10]} are not an event",
        f"the last event, {len(damaged) - places[-1]} bytes from byte {places[-1]}, is truncated",
    ]


def test_names_are_shown_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("\x1b[31m[red]\n", 5, bytes(8))
        log.write("\x1b[31m[red]\n", 5, bytes(7))
    assert main(["info", str(tmp_path / "log")]) == 0
    out = capsys.readouterr().out
    assert r"\x1b[31m[red]\n" in out
    assert "\x1b" not in out


def test_the_name_of_the_file_is_shown_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "a\x1b[31m\n.lcmlog"
    LogWriter(log).close()
    main(["info", str(log)])
    out = capsys.readouterr().out
    assert out.startswith(f"{tmp_path}/a\\x1b[31m\\n.lcmlog: 0 B")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("none", "there is no {tmp}/none\n  name a run folder or a log\n"),
        (".", "{tmp} holds no run.lcmlog\n  name a run folder or a log\n"),
    ],
)
def test_a_log_that_is_missing_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    for command in ("info", "play"):
        assert main([command, str(tmp_path / name)]) == 2
        assert capsys.readouterr().err == said.format(tmp=tmp_path)
