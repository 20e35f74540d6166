"""Lets the process of stages that loads it answer each time after a random while."""

import random
import socket
import time
from typing import Any

from graphnav import Stage, hookimpl
from graphnav.processes import hosted_stages
from graphnav.processes.frames import Frame, send

MAX_S = 0.01


def send_late(link: socket.socket, frame: Frame) -> None:
    time.sleep(random.uniform(0.0, MAX_S))
    send(link, frame)


module: Any = hosted_stages
module.send = send_late


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    return []
