"""A process of ``graphnav tunnel``: one LCM group, and an end of a tunnel for each host that is connected."""

from __future__ import annotations

import math
import select
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from graphnav import About, UserError
from graphnav.core.bus import Bus
from graphnav.core.errors import BusError
from graphnav.processes.host_link import HostCaller, HostLink, HostListener, LinkError, Refusal
from graphnav.processes.tunnel.end import TunnelEnd, Ways
from graphnav.processes.tunnel.motor_channels import MotorChannels
from graphnav.processes.tunnel.outbox import Accounts

SERVICE = "tunnel"
MAX_LINKS = 8
"""Hosts that are served at a time."""
_MAX_WAITING = 50_000
"""Messages that LCM queues: bounds memory, whatever is sent."""
_AT_ONCE = 2000
_MAX_PAUSE_S = 0.05


def refusal(error: LinkError, host: str, key_path: Path, otherwise: str) -> UserError:
    """Return what to do about an end that refuses this one for a reason that time does not change.

    ``otherwise``: the hint where it is neither another key nor another version.
    """
    hints = {
        Refusal.KEY: f"copy the key of {host} to {key_path}, with mode 0600",
        Refusal.VERSION: "use the same version of graphnav on both hosts",
    }
    return UserError.of(str(error), hints.get(error.reason, otherwise))


class Tunnel:
    """Carries messages between a group and other hosts; its owner calls `turn` again and again.

    A message that came through a tunnel is heard by no tunnel (`Bus`, ``forwards``): each goes at most one hop, so that
    tunnels may join groups in any way, several the same two. What another program sends again, such as a player of what
    it has recorded, is a new message. ``tell`` is told which hosts come and go.

    ``url``: of the group; with ``memq://`` what comes reaches only those who subscribe to `bus`, and nothing leaves.

    Raises BusError if LCM cannot be opened.
    """

    def __init__(
        self,
        url: str,
        ways: Ways,
        links: HostListener | HostCaller,
        tell: Callable[[str], None],
        notice: Callable[[str], None],
    ) -> None:
        self.ends: list[TunnelEnd] = []
        self.n_opened = 0
        """How many connections there were."""
        self.n_overruns = 0
        """How often the group was heard so slowly that LCM may have dropped messages, which it does not tell."""
        self._n_in_a_row = 0
        self.links = links
        self._ways, self._tell = ways, tell
        self._motors = MotorChannels()
        self._past = Accounts(), Accounts(), Accounts()
        is_private = url.startswith("memq:")
        self.bus = Bus(url, notice, forwards=not is_private)
        if not is_private:
            self.bus.subscribe_all(self._hear, _MAX_WAITING)

    def turn(self, timeout_s: float) -> None:
        """Wait for something to do, at most for a time, and do it.

        Raises
        ------
        LinkError
            The other end refuses this one for a reason that time does not change.
        """
        ready = self._poll(min(timeout_s, _MAX_PAUSE_S))
        self._hear_all()
        for link in self.links.step(ready, len(self.ends)):
            self._open(link)
        for end in tuple(self.ends):
            try:
                end.serve()
            except LinkError as error:
                self._close(end)
                self.links.lost(error)
                self._tell(str(error))

    def accounts(self) -> tuple[Accounts, Accounts, Accounts]:
        """Return the messages that came, those that left, and those that other ends did not send to this one."""
        came, left, lost = Accounts(), Accounts(), Accounts()
        for total, past, name in zip((came, left, lost), self._past, ("came", "left", "lost"), strict=True):
            total.add(past)
            for end in self.ends:
                total.add(getattr(end, name))
        for channel, n_overtaken in self.bus.overtaken.items():
            account = came.of(channel)
            account.dropped += n_overtaken
            account.passed -= n_overtaken
        return came, left, lost

    def close(self) -> None:
        """Close all connections and leave the group."""
        for end in tuple(self.ends):
            self._close(end)
        self.links.close()
        self.bus.close()

    def _poll(self, timeout_s: float) -> set[int]:
        """Wait until there is something to do; return the descriptors that are ready."""
        poll = select.poll()
        poll.register(self.bus.fileno(), select.POLLIN)
        for fd, events in self.links.pollables():
            poll.register(fd, events)
        until_s = time.monotonic() + timeout_s
        for end in self.ends:
            poll.register(end.link.fileno(), end.events())
            until_s = min(until_s, end.due_s())
        timeout_ms = max(0, math.ceil((until_s - time.monotonic()) * 1000))
        return {fd for fd, _ in poll.poll(timeout_ms)}

    def _hear_all(self) -> None:
        """Hear the messages that wait; notice when so many have come in a row that LCM may have dropped others."""
        with suppress(BusError, OSError, RuntimeError):
            for _ in range(_AT_ONCE):
                if not self.bus.handle(0.0):
                    self._n_in_a_row = 0
                    return
                self._n_in_a_row += 1
        if self._n_in_a_row > _MAX_WAITING:
            self._n_in_a_row = 0
            self.n_overruns += 1

    def _hear(self, channel: str, data: bytes) -> None:
        if channel == About.CHANNEL:
            self._motors.learn(data)
        now_s = time.monotonic()
        for end in self.ends:
            end.hear(channel, data, now_s)

    def _open(self, link: HostLink) -> None:
        try:
            self.ends.append(TunnelEnd(link, self.bus, self._ways, self._motors))
        except LinkError as error:
            link.close()
            self._tell(str(error))
        else:
            self.n_opened += 1
            again = "" if link.after_s is None else f" again, after {link.after_s:.1f} s"
            self._tell(f"connected to {link.peer}{again}")

    def _close(self, end: TunnelEnd) -> None:
        end.close()
        self.ends.remove(end)
        for past, closed in zip(self._past, (end.came, end.left, end.lost), strict=True):
            past.add(closed)
