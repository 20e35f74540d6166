"""``lcm-cli``, an independent implementation of LCM in pure Python, lists and decodes what we send and record."""

from __future__ import annotations

import importlib.util
import itertools
import os
import re
import subprocess
import sysconfig
import threading
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.messages import Flow, GuardState, Twist
from graphnav.core.record import LogWriter

LCM = Path(sysconfig.get_path("scripts")) / "lcm"
TYPES = Path(__file__).resolve().parents[2] / "lcmtypes"
FLOW = Flow(np.full((120, 160, 2), 0.5, np.float32), np.ones((120, 160), np.uint8), 100_000)
STOPPED = GuardState(
    may_move=False,
    may_advance=False,
    overridden=False,
    stopped=True,
    causes=("stop",),
    ports=("stop",),
    values=np.zeros(1),
    limits=np.zeros(1),
)

pytestmark = pytest.mark.skipif(importlib.util.find_spec("lcm_cli") is None, reason="lcm-cli is not installed")


def lcm_cli(*words: str | Path) -> str:
    """Return what lcm-cli prints."""
    environment = {**os.environ, "COLUMNS": "120", "NO_COLOR": "1"}
    done = subprocess.run([LCM, *words], capture_output=True, text=True, env=environment, check=True, timeout=60)
    return done.stdout


@pytest.fixture
def live(group: str) -> Iterator[list[str]]:
    """Return the options that name the group on which messages are published until the test ends."""
    over = threading.Event()

    def publish() -> None:
        bus = Bus(group)
        for k in itertools.count():
            bus.publish("control.twist", encode(Twist(0.25, -0.5), k, k))
            bus.publish("flow.flow", encode(FLOW, k, k))
            bus.publish("guard.state", encode(STOPPED, k, k))
            if over.wait(0.02):
                break
        bus.close()

    thread = threading.Thread(target=publish)
    thread.start()
    parts = urlsplit(group)
    yield ["--lcm-url", str(parts.hostname), "--lcm-port", str(parts.port)]
    over.set()
    thread.join()


def test_it_lists_our_channels(live: list[str]) -> None:
    said = lcm_cli("topic", "list", "-d", "1", *live)
    assert {"control.twist", "flow.flow"} <= set(said.split())


@pytest.mark.parametrize(
    ("channel", "fields"),
    [("control.twist", [r"v_mps: 0\.25", r"omega_radps: -0\.5"]), ("guard.state", ["stopped: True", "n_causes: 1"])],
)
def test_it_decodes_our_messages_by_our_definitions(live: list[str], channel: str, fields: list[str]) -> None:
    said = lcm_cli("topic", "echo", channel, "-n", "1", "-t", "20", "-f", TYPES, *live)
    assert all(re.search(rf"\b{field}\b", said) for field in fields)


def test_it_reads_our_logs(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "run.lcmlog") as log:
        for k in range(3):
            log.write("control.twist", k, encode(Twist(0.25, -0.5), k, k))
    said = lcm_cli("topic", "list", "--from", tmp_path / "run.lcmlog")
    assert "control.twist" in said.split()
