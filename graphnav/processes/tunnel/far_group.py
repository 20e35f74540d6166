"""The group of another computer, heard in this process alone: what ``graphnav tunnel --serve`` there gives."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Collection

from graphnav import UserError
from graphnav.core.cli import counted
from graphnav.core.graph import RESERVED
from graphnav.processes.host_key import key_file, read_key
from graphnav.processes.host_link import HostCaller, LinkError
from graphnav.processes.hosts import named_here
from graphnav.processes.tunnel import PORT
from graphnav.processes.tunnel.choice import Choice, Chosen
from graphnav.processes.tunnel.end import Ways
from graphnav.processes.tunnel.tunnel import SERVICE, Tunnel, refusal

_OF_RUNS = f"{re.escape(RESERVED)}.*"
_OTHERS_HZ = 2.0
"""Of channels that are not needed: they show that they are there, and a guard that it lives."""
_FIRST_S = 1.0
"""The first connection is waited for so long."""
_LOOK_S = 1.0


class FarGroup:
    """Hears the group of another computer and sends nothing to it; used as a `Bus` whose owner hears all channels.

    It calls until the other computer answers, and again after a cut. ``host``: an address, or a name of ``hosts.yaml``
    in the working folder. ``channels``: those that are needed completely, None for all; of each other one come at most
    2 messages a second. ``failure``: why nothing comes, and in a second line what to do; empty while it is connected,
    and after `close` what it was. ``losses``: a phrase about what the other computer dropped since the connection is
    slow.

    Raises UserError if the key is missing or ``hosts.yaml`` is wrong.
    """

    def __init__(self, host: str, port: int | None, channels: Collection[str] | None) -> None:
        self._host, self._port = host, port or PORT
        declared = named_here().get(host)
        self._address = host if declared is None else declared.address
        self._key_path = key_file(None)
        self._key = read_key(self._key_path)
        self._wanted = _wanted(channels)
        self._tunnel: Tunnel | None = None
        self._told = ""
        self._refusal: UserError | None = None
        self.failure = self.losses = ""
        self._connected_s: float | None = None
        self._look_s = 0.0
        self.name = f"{f'[{host}]' if ':' in host else host}:{self._port}"

    def subscribe_all(self, handler: Callable[[str, bytes], None], _: int = 0) -> None:
        """Connect, for which it waits a second at most; `handle` gives the messages to ``handler``.

        Raises
        ------
        UserError
            The other computer refuses this one for a reason that time does not change.
        """
        caller = HostCaller(self._address, self._port, self._key, SERVICE)
        self._tunnel = Tunnel("memq://", Ways(self._wanted, Choice([])), caller, self._note, self._note)
        self._tunnel.bus.subscribe_all(handler)
        end_s = time.monotonic() + _FIRST_S
        try:
            while not self._tunnel.ends and not caller.failure and (left_s := end_s - time.monotonic()) > 0:
                self.handle(left_s)
        except BaseException:
            self.close()
            raise

    def handle(self, timeout_s: float) -> bool:
        """Wait for messages and give them to the handler; return whether some arrived.

        Raises
        ------
        UserError
            As `subscribe_all`, and from then on each time.
        """
        tunnel = self._tunnel
        assert tunnel is not None
        if self._refusal is not None:
            raise self._refusal
        try:
            tunnel.turn(timeout_s)
        except LinkError as error:
            otherwise = f"name the port of 'graphnav tunnel --serve' on {self._host}; this one is {self._port}"
            self._refusal = refusal(error, self._host, self._key_path, otherwise)
            self.failure = str(self._refusal)
            raise self._refusal from error
        self._look(tunnel)
        return tunnel.bus.drain() > 0

    @property
    def connected_for_s(self) -> float:
        """How long it has been connected, 0 while it is not."""
        return 0.0 if self._connected_s is None else time.monotonic() - self._connected_s

    def dropped_packets(self) -> int:
        """Return 0: nothing comes by packets that the kernel can drop."""
        return 0

    def close(self) -> None:
        """Close the connection."""
        tunnel, self._tunnel = self._tunnel, None
        if tunnel is not None:
            tunnel.close()

    def _look(self, tunnel: Tunnel) -> None:
        """Note whether it is connected, and now and then what is lost."""
        now_s = time.monotonic()
        if tunnel.ends:
            self.failure = ""
            self._connected_s = now_s if self._connected_s is None else self._connected_s
        else:
            self._connected_s = None
            why = tunnel.links.failure or self._told or f"not yet connected to {self._host}, port {self._port}"
            self.failure = f"{why}\n  start 'graphnav tunnel --serve' on {self._host}, or name another address"
        if now_s >= self._look_s:
            self._look_s = now_s + _LOOK_S
            n = sum(passed.dropped for passed in tunnel.accounts()[2].channels.values())
            self.losses = f"{counted(n, 'message')} dropped by {self._host}: the connection is slow" if n else ""

    def _note(self, line: str) -> None:
        self._told = line


def _wanted(channels: Collection[str] | None) -> Choice:
    """Return what to ask the other computer for."""
    if channels is None:
        return Choice([Chosen(".*")])
    needed = [Chosen(re.escape(channel)) for channel in channels]
    return Choice([*needed, Chosen(_OF_RUNS), Chosen(".*", _OTHERS_HZ)])
