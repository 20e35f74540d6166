"""Play recorded channels as inputs, at their stamps, in a thread."""

from __future__ import annotations

import heapq
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from graphnav import GraphnavError, Recording, UserError
from graphnav.core.codec import codec_of
from graphnav.core.graph import InputChannel
from graphnav.core.record import find_log
from graphnav.live.inputs.receiver import Mailbox


class Playback:
    """Plays recorded channels into mailboxes on a common timeline that begins with their earliest stamp.

    ``is_over`` is True after the last message.

    Raises UserError if a log does not contain a channel, or has it with another type.
    """

    def __init__(self, played: Sequence[tuple[InputChannel, Mailbox]], wake: Callable[[], None]) -> None:
        self.is_over = False
        self.failure = ""
        self._wake = wake
        self._ending = threading.Event()
        logs: dict[Path, Recording] = {}
        streams = []
        for number, (source, mailbox) in enumerate(played):
            assert source.log is not None
            if source.log not in logs:
                logs[source.log] = Recording(find_log(source.log))
            streams.append(_stream(logs[source.log], source, number, mailbox))
        self._logs = list(logs.values())
        self._events = heapq.merge(*streams, key=lambda one: one[:2])
        self._thread = threading.Thread(target=self._serve, name="graphnav-playback", daemon=True)

    def start(self) -> None:
        """Start playing."""
        self._thread.start()

    def close(self) -> None:
        """Stop playing and close the logs."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join()
        for log in self._logs:
            log.close()

    def _serve(self) -> None:
        begin_s = first = None
        try:
            for utime, _, mailbox, data in self._events:
                if begin_s is None or first is None:
                    begin_s, first = time.monotonic(), utime
                if self._ending.wait(max(0.0, begin_s + (utime - first) / 1e6 - time.monotonic())):
                    return
                mailbox.put(data, time.monotonic())
                self._wake()
        except GraphnavError as error:
            self.failure = str(error)
        self.is_over = True
        self._wake()


def _stream(
    recording: Recording, source: InputChannel, number: int, mailbox: Mailbox
) -> Iterator[tuple[int, int, Mailbox, bytes]]:
    """Return (stamp, number of the input, mailbox, bytes) of each message of a recorded channel.

    Raises
    ------
    UserError
        The channel does not exist, or has another type.
    """
    if not recording.count(source.name):
        known = ", ".join(sorted(recording.channels))
        hint = f"it has {known}" if known else "it is empty"
        raise UserError.of(f"{recording.path} does not contain the channel '{source.name}'", hint, source.place)
    data = recording.event(source.name, 0).data
    if not data.startswith(codec_of(source.lcm_class).fingerprint):
        found = recording.channels[source.name]
        kind = "another type" if found is None else found.__name__
        raise UserError.of(
            f"channel '{source.name}' of {recording.path} is {kind}, not {source.type_name}", "", source.place
        )
    stamps = recording.utimes(source.name)
    return ((stamps[k], number, mailbox, recording.event(source.name, k).data) for k in range(len(stamps)))
