"""A log of types that graphnav does not know: shown, counted, played, and with ``--types`` decoded."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import lcm
from testbed.drives import GRAPHNAV
from testbed.processes import group_url

from tests.targets import Targets

_DEFINITIONS = {
    "joint_t": "package arm;\n\nstruct joint_t\n{\n    string name;\n    double angle_rad;\n}\n",
    "arm_t": "package arm;\n\nstruct arm_t\n{\n    int64_t stamp;\n    int32_t n;\n    joint_t joints[n];\n}\n",
    "force_t": "package arm;\n\nstruct force_t\n{\n    int64_t stamp;\n    float newton[3];\n}\n",
}
_N = 200
_PERIOD_US = 10_000
_CHANNELS = ("ARM", "FORCE")
_N_ALL = _N * len(_CHANNELS)


def test_exchange_a_log_of_unknown_types(targets: Targets, tmp_path: Path) -> None:
    """Each command reads a log that LCM's own Python wrote."""
    log, types = _write(tmp_path)
    shown = json.loads(_said("spy", "--json", log))["channels"]
    spied = sum(shown[channel]["messages"] for channel in _CHANNELS)
    unknown = sum("unknown" in line for line in _said("spy", "--once", log).splitlines())
    counted = _counted(json.loads(_said("info", log, "--json")))
    heard = _played(log, group_url(233))
    targets.check(
        f"a log of types that graphnav does not know, {_N_ALL} messages: 'spy' shows {spied} on {len(shown)} channels, "
        f"{unknown} of unknown type; 'info' counts {counted}; 'play' sends {heard}",
        good=spied == counted == heard == _N_ALL and unknown == len(_CHANNELS),
    )
    decoded = sum(_n_decoded(channel, log, types) for channel in _CHANNELS)
    named = sum(f"arm.{name}" in _said("info", log, "--types", types) for name in ("arm_t", "force_t"))
    targets.check(
        f"with --types: {decoded} of {_N_ALL} decoded, 'info' names {named} of {len(_CHANNELS)} types",
        good=decoded == _N_ALL and named == len(_CHANNELS),
    )


def _write(folder: Path) -> tuple[Path, Path]:
    """Return the log and the folder of its definitions."""
    types = folder / "types"
    types.mkdir(parents=True)
    for name, text in _DEFINITIONS.items():
        (types / f"{name}.lcm").write_text(text)
    tool = Path(lcm.LCM_BIN_DIR) / "lcm-gen"
    subprocess.run([tool, "-p", "--ppath", folder / "python", *types.iterdir()], check=True, capture_output=True)
    sys.path.insert(0, str(folder / "python"))
    arm: Any = importlib.import_module("arm")
    sys.path.remove(str(folder / "python"))
    log = lcm.EventLog(str(folder / "foreign.lcmlog"), "w", overwrite=True)
    for k in range(_N):
        joint = arm.joint_t()
        joint.name, joint.angle_rad = "elbow", 0.01 * k
        posture, force = arm.arm_t(), arm.force_t()
        posture.stamp = force.stamp = k
        posture.n, posture.joints, force.newton = 1, [joint], [0.5 * k, 0.0, -1.0]
        for channel, message in zip(_CHANNELS, (posture, force), strict=True):
            log.write_event(_PERIOD_US * (k + 1), channel, message.encode())
    log.close()
    return folder / "foreign.lcmlog", types


def _counted(info: dict[str, Any]) -> int:
    return sum(channel["messages"] for channel in info["channels"].values())


def _played(log: Path, url: str) -> int:
    """Return how many messages a plain LCM program hears while the log is played."""
    ear = lcm.LCM(f"{url}&recv_buf_size=2097152")
    heard: list[str] = []
    for name in _CHANNELS:
        ear.subscribe(name, lambda channel, _: heard.append(channel)).set_queue_capacity(0)
    command = [str(GRAPHNAV), "play", str(log), "--url", url]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as player:
        while player.poll() is None:
            ear.handle_timeout(100)
        end_s = time.monotonic() + 1.0
        while time.monotonic() < end_s:
            ear.handle_timeout(100)
    return len(heard) if not player.returncode else 0


def _n_decoded(channel: str, log: Path, types: Path) -> int:
    """Return how many messages come with the fields that were written."""
    said = _said("echo", channel, log, "--types", types, "--jsonl", "--full")
    lines = [json.loads(line)["fields"] for line in said.splitlines()]
    if channel == "ARM":
        return sum(line["joints"] == [{"name": "elbow", "angle_rad": 0.01 * k}] for k, line in enumerate(lines))
    return sum(line["newton"] == [0.5 * k, 0.0, -1.0] for k, line in enumerate(lines))


def _said(*words: str | Path) -> str:
    return subprocess.run([GRAPHNAV, *words], capture_output=True, text=True, check=True).stdout
