"""Open a log, of LCM or a ROS 2 bag, choose a channel in it, and read its pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graphnav import GraphnavError, Image, Message, ParamError, Recording, UserError
from graphnav.arrays import Bytes, Indices


class LogFrames:
    """The pictures of a channel in the order of their stamps; of several with one stamp the first.

    ``utimes``: int64 (n,), their stamps, increasing. ``rate_hz``: 0, since a log has times in place of a rate.
    """

    rate_hz = 0.0

    def __init__(self, log: Recording, channel: str) -> None:
        self.log = log
        self._channel = channel
        self.utimes, self._order = _by_stamp(log, channel)
        self._next = 0

    @property
    def at_end(self) -> bool:
        """Whether no picture is left."""
        return self._next == len(self._order)

    def read(self) -> Bytes | None:
        """Return the next picture, None after the last.

        Raises
        ------
        ValueError
            The message is not a picture that can be read.
        """
        if self.at_end:
            return None
        try:
            message = self.log.message(self._channel, int(self._order[self._next]))[2]
        except GraphnavError as error:
            raise ValueError(str(error)) from error
        self._next += 1
        assert isinstance(message, Image), "the channel was chosen by its type"
        return message.pixels

    def close(self) -> None:
        """Close the log."""
        self.log.close()


def _by_stamp(log: Recording, channel: str) -> tuple[Indices, Indices]:
    utimes, order = np.unique(np.array(log.utimes(channel), np.int64), return_index=True)
    return utimes, order


def open_log_frames(path: Path, channel: str | None) -> LogFrames:
    """Open the pictures of a log; ``channel``: None is its only one with images.

    Raises
    ------
    ParamError
        The log cannot be read, or the channel is not known.
    """
    log = opened_log("path", path)
    try:
        return LogFrames(log, channel_of(log, Image, channel, "image_channel"))
    except ParamError:
        log.close()
        raise


def opened_log(param: str, path: Path, hint: str = "give an LCM log (.lcmlog) or a ROS 2 bag") -> Recording:
    """Return an open log; raises ParamError for ``param`` if it cannot be read, with ``hint`` if none is known."""
    try:
        return Recording(path)
    except UserError as error:
        problem = error.problems[0]
        where = f"{problem.place}: " if problem.place else ""
        raise ParamError(param, f"{where}{problem.what}", problem.hint) from error
    except GraphnavError as error:
        raise ParamError(param, str(error), hint) from error


def channel_of(log: Recording, kind: type[Message], channel: str | None, param: str) -> str:
    """Return the channel or topic of a type that is asked for, of the only one if none is.

    Raises
    ------
    ParamError
        The log has none or several of the type, or the channel is of another one; names those that it has.
    """
    known = channels_of(log, kind)
    if channel is None and len(known) == 1:
        return known[0]
    if channel is not None and channel in known:
        return channel
    word = "channel" if log.bag is None else "topic"
    count = f"no {word} '{channel}'" if channel else f"{len(known) or 'no'} {word}{'' if len(known) == 1 else 's'}"
    hint = f"its {word}s of {kind.__name__} are {', '.join(known) or 'none'}"
    if log.bag is not None and log.bag.types and not known:
        hint += f"; it holds {', '.join(f'{name} ({ros_type})' for name, ros_type in log.bag.types.items())}"
    raise ParamError(param, f"'{log.path}' has {count} of {kind.__name__}", hint)


def channels_of(log: Recording, kind: type[Message]) -> list[str]:
    """Return the channels of a log that have messages of a type."""
    return [name for name, found in log.channels.items() if found is kind.lcm_class]
