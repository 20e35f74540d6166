"""The files by which systemd or Docker Compose keep a live graph running."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from graphnav import UserError, __version__
from graphnav.core.errors import shown_name

WRITTEN = "# Written by graphnav deploy, which replaces it when it is run again."
"""The first line of each file."""
_FINAL_STOPS_S = 1.5
"""Longer than the motor process sends stops after a run has died."""
_STOP_S = 15
"""So long a run may take to end its processes and to write its summary."""
_START_S = 120


class Service(NamedTuple):
    """A run that is kept running."""

    name: str
    """Of the unit and of the container, without prefix."""
    about: str
    program: str
    """The path of ``graphnav`` on this machine."""
    arguments: Sequence[str]
    """Of ``graphnav``, which hold on any machine with the same files."""
    environment: Mapping[str, str]
    reads: Sequence[Path]
    """The folders of its files that are not below the next, absolute."""
    works_in: Path
    """The working folder, in which ``runs`` gets the run folders, absolute."""
    user: str
    buffer_bytes: int
    """Of the receive buffer that its LCM URL requests."""
    restart: str
    watchdog_s: float
    """After so long an engine that does not turn is ended."""

    @property
    def unit(self) -> str:
        """The name of the unit."""
        return f"graphnav-{self.name}"


def systemd_files(service: Service) -> dict[str, str]:
    """Return what a unit and a file of the kernel's settings that it needs contain, by file name.

    Raises
    ------
    UserError
        A path or an argument that no unit can hold.
    """
    return {
        f"{service.unit}.service": _unit(service),
        f"90-{service.unit}.conf": (
            f"{WRITTEN}\n# For /etc/sysctl.d: the receive buffer that the run requests; a smaller one loses large\n"
            f"# messages of senders that leave no gaps between packets.\nnet.core.rmem_max = {service.buffer_bytes}\n"
        ),
    }


def _unit(service: Service) -> str:
    command = " ".join(_word(one, is_command=True) for one in (service.program, *service.arguments))
    environment = [f"Environment={_word(f'{name}={value}')}" for name, value in service.environment.items()]
    return "\n".join([
        WRITTEN,
        "",
        "[Unit]",
        f"Description=graphnav {_value(service.name)}{f': {_value(service.about)}' if service.about else ''}",
        "After=network-online.target",
        "Wants=network-online.target",
        "# After five failed starts within a minute it is left alone: systemctl reset-failed starts over.",
        "StartLimitIntervalSec=60",
        "StartLimitBurst=5",
        "",
        "[Service]",
        "# The run tells when its stages, inputs and motors are ready, and from then on that its engine turns.",
        "Type=notify",
        "NotifyAccess=main",
        f"TimeoutStartSec={_START_S}",
        f"WatchdogSec={service.watchdog_s:g}",
        f"User={_value(service.user)}",
        f"WorkingDirectory={_value(str(service.works_in))}",
        *environment,
        f"ExecStart={command}",
        f"Restart={service.restart}",
        "RestartSec=1",
        "# The status of a run that SIGTERM or Ctrl-C ended.",
        "SuccessExitStatus=130",
        "# Each process gets the signal. The run stops the motors and ends the others; where it has died, the process",
        "# that sends the motor channels sends stops for a second. After the watchdog's signal ExecStopPost waits.",
        "KillMode=control-group",
        f"TimeoutStopSec={_STOP_S}",
        f"ExecStopPost=/bin/sleep {_FINAL_STOPS_S:g}",
        "# The process that sends the motor channels asks for this.",
        "LimitRTPRIO=1",
        "StandardOutput=journal",
        "StandardError=journal",
        "",
        "[Install]",
        "WantedBy=multi-user.target",
        "",
    ])  # fmt: skip


def compose_files(service: Service) -> dict[str, str]:
    """Return what ``compose.yaml`` and a Dockerfile contain, by file name."""
    image = f"graphnav:{__version__}"
    read = [{"type": "bind", "source": str(one), "target": str(one), "read_only": True} for one in service.reads]
    content = {
        "image": image,
        "command": ["graphnav", *service.arguments],
        "environment": dict(service.environment),
        "working_dir": str(service.works_in),
        "volumes": [*read, {"type": "bind", "source": str(service.works_in), "target": str(service.works_in)}],
        "network_mode": "host",
        "init": True,
        "restart": service.restart,
        "stop_signal": "SIGTERM",
        "stop_grace_period": f"{_STOP_S}s",
        "healthcheck": {
            "test": ["CMD", "graphnav", "top", "--once"],
            "interval": "10s",
            "timeout": "10s",
            "start_period": f"{_START_S}s",
            "retries": 3,
        },
        "cap_add": ["SYS_NICE"],
        "logging": {"driver": "journald"},
    }
    lines = [f"    {key}: {json.dumps(value).replace('$', '$$')}" for key, value in content.items()]
    return {
        "compose.yaml": "\n".join([
            WRITTEN,
            f"# Of the host: sysctl -w net.core.rmem_max={service.buffer_bytes}",
            f"name: {service.unit}",
            "services:",
            f"  {service.name}:",
            *lines,
            "",
        ]),
        "Dockerfile": "\n".join([
            WRITTEN,
            f"# docker build -t {image} -f Dockerfile FOLDER, which holds the source of graphnav",
            "FROM python:3.12-slim",
            "COPY . /source",
            "RUN pip install --no-cache-dir /source",
            "# Packages with stages of your own: RUN pip install ...",
            "",
        ]),
    }  # fmt: skip


def _value(text: str) -> str:
    """Return a value that systemd takes as it stands, ``%`` escaped."""
    if text != text.strip() or "\\" in text or not text.isprintable():
        what = (
            f"{shown_name(text)} cannot stand in a unit: it has a backslash, or space or control characters at an end"
        )
        raise UserError.of(what, "rename it, or work in another folder")
    return text.replace("%", "%%")


def _word(text: str, *, is_command: bool = False) -> str:
    """Return a word of a line that systemd splits."""
    if not text.isprintable():
        what = f"{shown_name(text)} cannot stand in a unit: it has control characters"
        raise UserError.of(what, "rename it, or write it without them")
    text = text.replace("%", "%%")
    text = text.replace("$", "$$") if is_command else text
    if text and not re.search(r"""[\s"'\\;]""", text):
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
